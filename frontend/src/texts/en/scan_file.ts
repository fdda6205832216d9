import { number } from "./counting";

const signed = (value: number): string => number.format(value).replace("-", "−");

/** Exports of a scan for other programs. */
export const scanFile = {
  title: "Export the scan for other programs",
  lead: "Create a file that other programs can open: the whole scan for research and treatment planning, or a 3D model of a part of it, for example to print a bone.",
  warning:
    "The file may identify the patient. A model of the skin of a head shows the face, and so can the whole scan. Give the file only to people you trust.",
  format: "Format",
  formats: {
    nifti: "Whole scan (NIfTI)",
    stl: "3D model for printing (STL)",
    glb: "3D model with colour (glTF)",
  },
  formatHints: {
    nifti: "Contains every value of the scan as it is stored here, with its position in the patient.",
    stl: "In millimetres, without holes. The colour isn’t part of this format.",
    glb: "In metres, without holes, for 3D programs and web pages.",
  },
  part: "Part of the scan",
  byValue: "Everything above a value",
  above: "Lowest value of the part",
  aboveHounsfield: "Lowest value of the part, in HU",
  aboveHintCt: "300 HU shows the bones, −300 HU the skin.",
  aboveHint: (minimum: number, maximum: number) =>
    `The values of this scan lie between ${signed(minimum)} and ${signed(maximum)}. Brighter tissue has higher values.`,
  wrongAbove: (minimum: number, maximum: number) =>
    `Enter a whole number between ${signed(minimum)} and ${signed(maximum)}.`,
  create: "Create the file",
  queued: "The file is being created. You can close this window in the meantime.",
  waiting:
    "The server can’t create the file at the moment. It will do so as soon as it can. You can close this window in the meantime.",
  stop: "Stop",
  ready: (format: string, size: string) => `${format}: the file is ready, ${size}.`,
  get: "Download",
  another: "Delete the file",
  busy: "Another file of yours is still being created. Wait until it is ready, then try again.",
  failed: "The file couldn’t be created. Try again.",
  failures: {
    nothing_inside: "Nothing in the scan has this label or a value this high. Choose another part.",
    too_large: "This part of the scan is too large to export. Choose a smaller part.",
    too_slow: "Creating the file took too long. A smaller part may work.",
    no_memory: "The server ran out of memory each time it tried to create the file. Choose a smaller part.",
  },
} as const;
