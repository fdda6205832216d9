import { count } from "./counting";

/** Leaves out what there is none of, unless there is neither. */
const both = (marks: number, measures: number): string =>
  [
    marks > 0 || measures === 0 ? count(marks, "mark", "marks") : "",
    measures > 0 ? count(measures, "measurement", "measurements") : "",
  ]
    .filter(Boolean)
    .join(" and ");

/** Marks: arrows, circles, texts and measurements in the scan. */
export const marks = {
  lead: "Choose what to add, then press a point of the picture or of a slice. Drag to set its size. A mark stays at its point of the scan and is drawn dashed while it lies behind something.",
  kinds: { arrow: "Arrow", circle: "Circle", text: "Text", ruler: "Ruler", angle: "Angle" },
  press: {
    arrow: "Press the point that the arrow should point to, and drag to where it begins.",
    circle: "Press the middle of the circle, and drag to its edge.",
    text: "Press the point that the text is about.",
    ruler:
      "Press two points, or drag from one to the other. In the picture, a point lies on the surface there, to within about 1% of the size of the scan.",
    angle:
      "Press three points. The second one is the vertex. In the picture, a point lies on the surface there, to within about 1% of the size of the scan.",
  },
  nextPoint: (point: number, count: number) => `Now press point ${point} of ${count}.`,
  nothingThere: "There is nothing of the scan at this point. Choose another one.",
  full: "You can show at most 50 marks at a time. Delete or hide some first.",
  colour: "Colour",
  colours: ["Orange", "Blue", "Pink", "Green", "Yellow", "Violet", "Turquoise", "Red"],
  text: "Text",
  textHint: "Everyone to whom you show this mark can read the text. Don’t write a name that they shouldn’t see.",
  shown: "Show my marks",
  here: "Marks in the picture",
  none: "There are no marks yet.",
  nameOf: (kind: "arrow" | "circle" | "text" | "ruler" | "angle", text: string) =>
    text || { arrow: "Arrow", circle: "Circle", text: "Empty text", ruler: "Ruler", angle: "Angle" }[kind],
  by: (name: string) => `by ${name}`,
  keep: "Keep a copy",
  keepOf: (mark: string) => `Keep a copy of ${mark}`,
  remove: "Delete",
  removeOf: (mark: string) => `Delete ${mark}`,
  choose: (mark: string) => `Choose ${mark}`,
  moveOf: (mark: string) => `Move ${mark}`,
  tailOf: (mark: string) => `Move the beginning of ${mark}`,
  secondOf: (mark: string) => `Move the second point of ${mark}`,
  thirdOf: (mark: string) => `Move the third point of ${mark}`,
  edgeOf: (mark: string) => `Change the size of ${mark}`,
  guestsOff: "The presenter has turned off the marks of guests, so only you see yours.",
  saved: {
    title: "Saved with this scan",
    lead: "Only you see what you save here, unless you share it.",
    leadShared: "These marks belong to the owner of the scan.",
    unsaved: (marks: number, measures: number) => `Not saved yet: ${both(marks, measures)}.`,
    name: "Name",
    save: "Save",
    added: (name: string) => `Saved as ${name}. Later changes are saved by themselves.`,
    content: (marks: number, measures: number) => both(marks, measures),
    share: "Everyone who can open this scan sees it",
    shareHint:
      "Shared marks are visible to everyone with whom you share the scan, also without an account through a link, and in the gallery if the scan is public.",
    shared: "shared",
    rename: "Rename",
    renameOf: (name: string) => `Rename ${name}`,
    newName: "New name",
    remove: "Delete",
    removeOf: (name: string) => `Delete ${name}`,
    removeSure: (name: string) => `Permanently delete “${name}” with all its marks and measurements?`,
  },
  /** The option to include marks and measurements in a link or a preset. */
  include: (marks: number, measures: number) => `Include ${both(marks, measures)}`,
  inPicture: {
    include: (marks: number) => `Draw ${count(marks, "mark", "marks")} into the picture`,
    hint: "The texts of the marks can then be read in the picture.",
  },
  inVideo: {
    include: (marks: number) => `Draw ${count(marks, "mark", "marks")} into the video`,
    hint: "The marks stay at their points of the scan, and their texts can be read in the video.",
  },
  includeHint: "Everyone who opens it can read the texts of the marks.",
} as const;
