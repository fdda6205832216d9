import type { LeftOut, Repair } from "../../scan/types";
import { count, number } from "./counting";
import { reasons } from "./reasons";

/** Add a scan: the folder, what was found in it, and why some of it does not fit. */
export const add = {
  lead: "Choose the folder or disc that the hospital gave you. The slices are found by themselves, whatever the files are called.",
  privacy: "Names, dates and numbers of the patient are cut out of the files before they are sent: they never leave this browser. The server keeps only the volume and deletes the files.",
  privacy_short: "The patient’s name is shown here only. It is cut out before anything is sent.",
  drop: "Drop a folder here",
  dropping: "Let go to look inside",
  or: "or",
  choose: "Choose a folder",
  scanning: "Looking at the files…",
  scanned: (done: number, total: number) => `${number.format(done)} of ${count(total, "file", "files")}`,
  stop: "Stop",
  another: "Choose another folder",
  failed: "The folder could not be read. Try again.",
  found: (n: number) => (n === 1 ? "One series can be shown" : `${number.format(n)} series can be shown`),
  nothing: "No scan here that can be shown",
  nothing_empty: "The folder is empty.",
  nothing_no_dicom: (n: number) => `None of the ${count(n, "file", "files")} is a DICOM file. Discs from hospitals often hold them in a folder called DICOM.`,
  nothing_hint: "This is what was found on it, and why it cannot be shown.",
  hidden: (n: number) => `${count(n, "series was", "series were")} hidden. Why?`,
  others: (n: number) => `${count(n, "file is", "files are")} not DICOM and left alone.`,
  unreadable: (n: number) => `${count(n, "file", "files")} could not be read.`,
  series_untitled: "Series without a name",
  slices: (n: number) => count(n, "slice", "slices"),
  size: (x: number, y: number, z: number) => `${x.toFixed(0)} × ${y.toFixed(0)} × ${z.toFixed(0)} mm`,
  born: (date: string) => `born ${date}`,
  patient_unknown: "Patient without a name",
  thumbnail: "Middle slice",
  no_thumbnail: "No preview: compressed",
  title: "Your name for this scan",
  title_hint: "Optional. Others do not see it; better no name of a person.",
  title_example: "Head, spring",
  upload: "Upload",
  starting: "Starting…",
  left_out: (left: LeftOut) =>
    [
      left.doubles > 0 ? `${count(left.doubles, "double", "doubles")} left out` : "",
      left.scouts > 0 ? `${count(left.scouts, "scout", "scouts")} left out` : "",
      left.others > 0 ? `${count(left.others, "slice", "slices")} of another size left out` : "",
      left.damaged > 0 ? `${count(left.damaged, "damaged slice", "damaged slices")} left out` : "",
    ].filter((text) => text !== ""),
  go_on: "Go on with the upload",
  go_on_text: (percent: number) => `The upload of this scan was interrupted at ${percent} %. What has arrived is not sent again.`,
  sent_elsewhere: "This scan is being uploaded in another window of this browser.",
  storage_full: "The server has no room left just now. Nothing was sent. Try again later.",
  repair: (repair: Repair) => {
    switch (repair.kind) {
      case "straightened":
        return `taken at a slant, will be straightened by ${repair.degrees.toFixed(1)} degrees`;
      case "filled_in":
        return `${count(repair.slices, "missing slice", "missing slices")} will be filled in from the neighbours`;
      case "varying":
        return `slices are ${repair.from_mm.toFixed(1)} to ${repair.to_mm.toFixed(1)} mm apart, so small things may look blurred`;
    }
  },
  not_slices: (n: number) => `${count(n, "file is", "files are")} no slices (reports, screenshots, plans).`,
  only_reports: "There are only reports or screenshots here, no slices of a scan. Ask for the pictures of the scan in DICOM format.",
  over_quota: (needs: string, free: string) => `This scan needs ${needs}, and ${free} of your space is free. Delete a scan first.`,
  too_large: "This scan is larger than an upload may be.",
  reasons,
} as const;
