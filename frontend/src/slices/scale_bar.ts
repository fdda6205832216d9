/** A round length and its size in the view. */
export interface ScaleBar {
  readonly mm: number;
  readonly pixels: number;
}

/** Returns the longest bar of 1, 2 or 5 times a power of ten mm that is at most `most` pixels long. */
export function scaleBar(pixelsPerMm: number, most: number): ScaleBar {
  const limit = most / pixelsPerMm;
  const power = 10 ** Math.floor(Math.log10(limit));
  // Allows a tiny tolerance, because 10 ** n is not exact for negative n.
  const factor = [5, 2].find((one) => one * power <= limit * (1 + 1e-12)) ?? 1;
  const mm = factor * power;
  return { mm, pixels: mm * pixelsPerMm };
}
