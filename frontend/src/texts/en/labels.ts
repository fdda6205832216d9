import { count, fixed } from "./counting";

/** Labels: structures that are marked in a scan, by a person or by the server. */
export const labels = {
  lead: "These structures are marked in the scan. Choose one to change its look. To see those inside the body, hide everything that isn’t marked.",
  coloured: "Show the structures in colour",
  name: "What is this?",
  press: "Press a structure in the picture to see its name.",
  done: "Done",
  noAnswer: "The server didn’t answer. Try again.",
  nothingThere: "There is nothing of the scan at this point. Choose another one.",
  unmarked: "No structure is marked here.",
  /** The parts that the server finds: the brain in MR, the others in CT. */
  found: {
    brain: "Brain, with the fluid around it",
    bone: "Bone",
    lungs: "Lungs",
    airways: "Airways",
    vessels: "Vessels with contrast medium",
  },
  /** Above the list, if the server has found all labels, or some. */
  allFound: "The server found these structures automatically. They can be wrong.",
  someFound: (names: string) => `The server found these automatically, and they can be wrong: ${names}.`,
  untitled: (number: number) => `Structure ${number}`,
  show: (name: string) => `Show ${name}`,
  only: "Only this",
  onlyOf: (name: string) => `Show only ${name}`,
  rest: "Show everything that isn’t marked",
  colour: "Colour",
  opacity: "Opacity",
  /** With three digits, or more for a large volume. */
  volume: (millilitres: number) => `${fixed(millilitres, millilitres < 10 ? 2 : millilitres < 100 ? 1 : 0)} ml`,

  title: (title: string) => `Labels of ${title}`,
  explain:
    "Labels mark the structures of a scan, for example organs. Choose a file that belongs to this scan: NIfTI (.nii, .nii.gz), DICOM segmentation (SEG) or DICOM structure set (RTSTRUCT). Then open the scan and choose “Labels” on the left.",
  privacy:
    "We send only the structures with their names and colours. Names, dates and ID numbers of the patient are removed from the file first. The people you share the scan with see the labels too. Guests, people with a link and the gallery don’t see their names.",
  choose: "Choose a file",
  replace: "Replace the labels",
  remove: "Remove the labels",
  none: "You haven’t added any labels to this scan.",
  has: (labels: number, bytes: string) => `This scan has ${count(labels, "label", "labels")} (${bytes}).`,
  onCard: (labels: number) => count(labels, "label", "labels"),
  /** Why the server refused a file, by its code. */
  refused: {
    labels_other_scan: "These labels don’t belong to this scan.",
    labels_old_scan: "This scan was added before it could have labels. Add the scan again, then add its labels.",
    labels_unsupported: "This kind of file isn’t supported.",
    labels_damaged: "The file of labels is damaged or contains no labels.",
    labels_too_large: "The file of labels is too large.",
    over_quota: "Your storage has no room for these labels. Delete other scans, then add the labels again.",
    infected: "The virus scanner found malicious software in this file, so it was deleted.",
    other: "The server couldn’t read this file. Try again.",
  },
  phases: { reading: "Reading the file…", sending: "Uploading…", placing: "Matching the labels to the scan…" },
  sending: (part: number) => `Uploading… ${Math.floor(100 * part)}%`,
  faults: {
    unknown: "This isn’t a file of labels. Choose a NIfTI label volume, a DICOM segmentation or a structure set.",
    damaged: "This file is damaged. Try copying it again.",
    too_large: "This file is too large.",
    rejected: "The server rejected the file. Try again.",
    over_quota: "Your storage has no room for these labels. Delete other scans first.",
    busy: "Earlier labels of this scan are still being processed. Try again in a moment.",
  },
} as const;
