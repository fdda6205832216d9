/** The slice views next to the 3D picture. */
export const slices = {
  open: "Show the slices (V)",
  close: "Show only the 3D view (V)",
  bar: "Slices",
  views: "Layout",
  view: { picture: "3D", four: "All", axial: "Axial", sagittal: "Sagittal", coronal: "Coronal" },
  tools: "Tool",
  tool: { window: "Window", crosshair: "Crosshair", ruler: "Ruler", angle: "Angle" },
  toolHelp: {
    window: "Drag sideways to change the contrast, and up or down to change the brightness.",
    crosshair:
      "Drag, click or tap to move all three slices to that point. With a mouse, you can also hold Shift and move the pointer at any time.",
    ruler:
      "Drag from one point to another, or click or tap both. With the keyboard, Enter sets a point at the crosshair.",
    angle:
      "Click or tap three points. The second one is the vertex. With the keyboard, Enter sets a point at the crosshair.",
  },
  usual: "Window",
  usualOwn: "Custom",
  usualWindows: { soft: "Soft tissue", lung: "Lung", bone: "Bone", brain: "Brain" },
  centre: "Centre",
  width: "Width",
  removeMeasure: "Delete the last measurement",
  reset: "Reset the slices",
  maximise: (view: string) => `Show only ${view} (M)`,
  restore: "Show all views (M)",
  canvas: (view: string) =>
    `${view} slice. The up and down arrows or Page Up and Page Down scroll through the slices, Shift and the arrows move the crosshair, Ctrl and the arrows move the slice, plus and minus zoom, M shows this slice alone, and R resets the slices.`,
  slider: (view: string) => `${view} slice`,
  number: (index: number, count: number) => `${index} of ${count}`,
  title: (view: string, index: number, count: number) => `${view} ${index}/${count}`,
  place: (parts: readonly { readonly side: string; readonly mm: number }[]) =>
    `${parts.map(({ side, mm }) => `${side} ${mm.toFixed(1)}`).join("  ")} mm`,
  hu: (value: number) => `${value} HU`.replace("-", "−"),
  value: (value: number) => `Value ${value}`.replace("-", "−"),
  nothing: "Outside the scan",
  cutAway: "Cut away",
  ruler: (mm: number) => `${mm.toFixed(1)} mm`,
  angle: (degrees: number) => `${degrees.toFixed(1)}°`,
  said: (title: string, value: string, place: string) => `${title}, ${value}, ${place}`,
  unsupported: "This browser is too old to show the slices. Update it, or use another browser.",
  damaged: "A slice was corrupted in transit. Reload the page to load it again.",
} as const;
