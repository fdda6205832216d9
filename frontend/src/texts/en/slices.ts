import { count, fixed, number } from "./counting";

/** Writes a typographic minus. */
const signed = (text: string): string => text.replace("-", "−");
/** Adds the unit to the values of a CT, which are in Hounsfield units. */
const withUnit = (text: string, hounsfield: boolean): string => `${signed(text)}${hounsfield ? " HU" : ""}`;

/** The slice views next to the 3D picture. */
export const slices = {
  open: "Show the slices (V)",
  close: "Show only the 3D view (V)",
  bar: "Slices",
  views: "Layout",
  view: { picture: "3D", four: "All", axial: "Axial", sagittal: "Sagittal", coronal: "Coronal" },
  tools: "Tool",
  tool: {
    window: "Window",
    crosshair: "Crosshair",
    tilt: "Tilt",
    curve: "Curve",
    ruler: "Ruler",
    angle: "Angle",
    ellipse: "Ellipse",
  },
  toolHelp: {
    window: "Drag sideways to change the contrast, and up or down to change the brightness.",
    crosshair:
      "Drag, click or tap to move all three slices to that point. With a mouse, you can also hold Shift and move the pointer at any time.",
    tilt: "Shows the thickness of slabs, too. Drag around the crosshair to turn the other two planes. With the keyboard, the comma and the full stop turn them.",
    curve:
      "Click or tap points along a vessel, the jaw or the spine, also in different slices. The slice along them appears straightened. Drag a point to move it. With the keyboard, Enter sets a point at the crosshair, and Backspace removes the last one.",
    ruler:
      "Drag from one point to another, or click or tap both. Drag an end to move it. With the keyboard, Enter sets a point at the crosshair, or picks up the point there.",
    angle:
      "Click or tap three points. The second one is the vertex. Drag a point to move it. With the keyboard, Enter sets a point at the crosshair, or picks up the point there.",
    ellipse:
      "Measures the values in an ellipse. Drag from one corner to the opposite one, or click or tap both. Drag the centre to move the ellipse, and a dot on its edge to resize it. With the keyboard, Enter sets a corner at the crosshair, or picks up the dot there.",
  },
  usual: "Window",
  usualOwn: "Custom",
  usualWindows: { soft: "Soft tissue", lung: "Lung", bone: "Bone", brain: "Brain" },
  centre: "Centre",
  width: "Width",
  oblique: "Thickness and tilt",
  slab: "Slab, mm",
  slabHelp:
    "The thickness of the slices in mm. Each pixel then combines the values through the slab. 0 shows thin slices.",
  projection: "Values of the slab",
  projections: { mean: "Mean", maximum: "Maximum", minimum: "Minimum" },
  straighten: "Undo the tilt",
  tilted: (degrees: number) => `tilted ${degrees.toFixed(1)}°`,
  thick: (mm: number, projection: string) => `${number.format(mm)} mm ${projection.toLowerCase()}`,
  /** The values of two scans at one point. */
  both: (first: string, second: string) => `${first}, second scan: ${second}`,
  interpolated: (value: string) => `${value}, interpolated`,
  removeMeasure: "Delete the last measurement",
  reset: "Reset the slices",
  maximise: (view: string) => `Show only ${view} (M)`,
  restore: "Show all views (M)",
  canvas: (view: string) =>
    `${view} slice. The up and down arrow keys or Page Up and Page Down scroll through the slices. Shift with an arrow key moves the crosshair. Ctrl with an arrow key pans the image. Plus and minus zoom. Comma and full stop tilt the other two planes. M shows only this slice. R resets the slices.`,
  slider: (view: string) => `${view} slice`,
  number: (index: number, count: number) => `${index} of ${count}`,
  title: (view: string, index: number, count: number) => `${view} ${index}/${count}`,
  place: (parts: readonly { readonly side: string; readonly mm: number }[]) =>
    `${parts.map(({ side, mm }) => `${side} ${mm.toFixed(1)}`).join("  ")} mm`,
  hu: (value: number) => withUnit(String(value), true),
  value: (value: number) => signed(`Value ${value}`),
  nothing: "Outside the scan",
  cutAway: "Cut away",
  ruler: (mm: number) => `${mm.toFixed(1)} mm`,
  angle: (degrees: number) => `${degrees.toFixed(1)}°`,
  ellipse: (mean: number, deviation: number, hounsfield: boolean) =>
    `Mean ${withUnit(`${fixed(mean, 1)} ± ${fixed(deviation, 1)}`, hounsfield)}`,
  ellipseRange: (minimum: number, maximum: number, hounsfield: boolean) =>
    `${signed(String(minimum))} to ${withUnit(String(maximum), hounsfield)}`,
  ellipseSize: (area: number, pixels: number) =>
    `${area < 100 ? fixed(area, 1) : number.format(Math.round(area))} mm², ${count(pixels, "pixel", "pixels")}`,
  ellipseEmpty: "No values inside",
  held: "Picked up. Shift and the arrows move it, and Enter puts it down.",
  curve: {
    name: "Curved slice",
    hint: "Press at least two points along a structure, in any slices. The slice along them appears here, straightened.",
    title: (mm: number) => `Curved slice, ${mm.toFixed(1)} mm long`,
    canvas:
      "Slice along the curve. The arrow keys move a pixel along and across the curve, and the crosshair follows. With Shift, they move ten pixels. Ctrl with an arrow key pans the image. Plus and minus zoom. Comma and full stop turn the slice around the curve. Backspace removes the last point. R shows all of the slice.",
    position: (along: number, across: number) => `${along.toFixed(1)} mm along, ${signed(across.toFixed(1))} mm across`,
    angleName: "Angle around the curve",
    angle: (degrees: number) => `Angle ${degrees}°`,
    angleHelp: "Turns the slice around the curve.",
    height: "Height, mm",
    heightHelp: "The size of the curved slice across the curve in mm.",
    undo: "Remove the last point of the curve",
    clear: "Delete the curve",
    full: "The curve has the maximum of 64 points.",
    noMeasures: "Straightening stretches or squeezes what lies beside the curve, so measure in the other slices.",
  },
  scale: (length: string) => `Scale: ${length}`,
  millimetres: (mm: number) => `${mm} mm`,
  centimetres: (cm: number) => `${cm} cm`,
  display: "Display",
  smooth: "Smooth",
  smoothHelp:
    "Shows smooth transitions between the stored values. Turn it off to see each stored value as a sharp rectangle. Readings and measurements are of the stored values, and in tilted slices and slabs of values between them.",
  overlay: "Colours",
  overlayHelp: "Shows the colours of the 3D picture over the grey slices.",
  overlayStrength: "Strength of the colours",
  labels: "Labels",
  labelsHelp:
    "Shows the structures of the list “Labels” over the slices, in its colours. In a thick slice, each pixel has the structure that is most frequent there.",
  labelsStrength: "Strength of the labels",
  said: (title: string, value: string, place: string) => `${title}, ${value}, ${place}`,
  unsupported: "This browser is too old to show the slices. Update it, or use another browser.",
  damaged: "A slice was corrupted in transit. Reload the page to load it again.",
} as const;
