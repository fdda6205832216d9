/** The curve of the noise level, and the files that it is saved as. */
export const curve = {
  save: "Save the curve",
  saveAs: (format: string) => `Save the curve as ${format}`,
  timeAxis: "Rendering time in s",
  samplesAxis: "Samples per pixel",
  errorAxis: "Noise level (relative error)",
  guide: "Slope −1/2: the error falls with the square root of time.",
  file: {
    title: "Error of the picture against rendering time",
    samples: "samples: samples per pixel.",
    seconds: "seconds: rendering time in seconds since the view was set, including the preparation of the scene.",
    error:
      "error: estimated root mean square difference between this picture and the converged one. 1 is the range from black to white on the screen, so 0.05 is 5%.",
    guide: "With a path tracer, the error falls with the square root of time: slope -1/2 with logarithmic axes.",
    source: (width: number, height: number, device: string) => `${width} × ${height} pixels, rendered on ${device}`,
  },
} as const;
