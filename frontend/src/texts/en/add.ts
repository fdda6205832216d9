import type { LeftOut, Phases, Repair } from "../../scan/types";
import { count, number } from "./counting";
import { reasons } from "./reasons";

const mostMs = 1000;
const secondsText = (ms: number): string =>
  ms < mostMs ? `${number.format(Math.round(ms))} ms` : `${number.format(Math.round(ms / 100) / 10)} s`;

/** Adding a scan: choosing the folder, the series found in it, and why some of them can't be shown. */
export const add = {
  lead: "Choose the folder, the disc or the ZIP file that the hospital gave you. Diaphane finds the scans in it, whatever the files are called.",
  privacy:
    "The patient’s name, dates and ID numbers are removed from the files before anything leaves this browser. We keep only the 3D image data and delete the uploaded files.",
  privacyShort: "The patient’s name is shown only to you, in this browser. It is removed before anything is uploaded.",
  drop: "Drop a folder or a ZIP file here",
  dropping: "Drop to read the files",
  or: "or",
  formats: "DICOM folders, ZIP and TAR archives, and NIfTI, NRRD or MetaImage files",
  choose: "Choose a folder",
  chooseFiles: "Choose files",
  scanning: "Reading the files…",
  scanned: (done: number, total: number) => `${number.format(done)} of ${count(total, "file", "files")}`,
  stop: "Stop",
  another: "Choose other files",
  failed: "The files couldn’t be read. Try again.",
  found: (n: number) => `${count(n, "image series", "image series")} can be shown`,
  nothing: "No scan found that can be shown",
  nothingEmpty: "This folder is empty. Choose another one.",
  nothingNoDicom: (n: number) =>
    `${n === 1 ? "This file isn’t a DICOM file." : `None of these ${number.format(n)} files is a DICOM file.`} Hospital discs often keep the scans in a folder called DICOM.`,
  nothingHint: "We found image series, but none of them can be shown. The reasons are listed below.",
  hidden: (n: number) => `${count(n, "image series", "image series")} can’t be shown. Why?`,
  others: (n: number) =>
    n === 1
      ? "1 file is not a DICOM file and was ignored."
      : `${number.format(n)} files are not DICOM files and were ignored.`,
  archives: {
    encrypted: (name: string) =>
      `“${name}” is protected by a password. Unpack it with the password first, then choose the unpacked folder.`,
    damaged: (name: string) =>
      `“${name}” is damaged or incomplete, so not all of its files could be read. Copy or download it again.`,
    nested: (name: string) =>
      `“${name}” contains archives within archives within archives. Unpack it first, then choose the unpacked folder.`,
    large: (name: string) =>
      `“${name}” contains more than this page can unpack. Unpack it first, then choose the folder with your scan.`,
    format: (name: string) =>
      `“${name}” is packed in a way that browsers can’t read. Unpack it first, then choose the unpacked folder.`,
  },
  damagedInArchive:
    "A file of this scan is damaged in its archive, so nothing was uploaded. Copy or download the archive again.",
  unreadable: (n: number) => `${count(n, "file", "files")} couldn’t be read.`,
  seriesUntitled: "Untitled series",
  slices: (n: number) => count(n, "slice", "slices"),
  size: (x: number, y: number, z: number) => `${x.toFixed(0)} × ${y.toFixed(0)} × ${z.toFixed(0)} mm`,
  born: (date: string) => `born ${date}`,
  patientUnknown: "The files contain no patient name",
  thumbnail: "Middle slice",
  noThumbnail: "No preview because the images are compressed",
  title: "Your name for this scan",
  titleProposed: "Suggested from the scan. Change it as you like.",
  titleHint: "Don’t include a person’s name: only you can see it at first, and later anyone you share the scan with.",
  titleExample: "Head, spring",
  best: "Best for a 3D picture",
  bestWhy: {
    thinnest: (mm: number) => `Its slices are the thinnest (${mm.toFixed(1)} mm), so the picture is the smoothest.`,
    largest: (mm: number) => `It shows the most of the body (${mm} mm).`,
  },
  several: "Upload as many of them as you like. This list stays open.",
  begun: "The upload has started. You can follow it under “My scans”.",
  upload: "Upload",
  uploadAll: (n: number) => `Upload all ${n}`,
  starting: "Starting…",
  phases: ({ kind, count: n, range: [from, to] }: Phases) => {
    const span = `${number.format(from)} to ${number.format(to)}`;
    switch (kind) {
      case "index":
        return count(n, "phase", "phases");
      case "time":
        return `${count(n, "phase", "phases")} over ${secondsText(to)}`;
      case "cycle":
        return `${count(n, "phase", "phases")} (${span}% of a heartbeat)`;
      case "echo":
        return `${count(n, "echo", "echoes")} (${span} ms)`;
      case "b_value":
        return `${count(n, "diffusion image", "diffusion images")} (b = ${span} s/mm²)`;
    }
  },
  phasesToUpload: "Phases to upload",
  allPhases: (n: number) => `All ${number.format(n)}`,
  everyPhase: (every: number, n: number) =>
    `Every ${["", "", "second", "third", "fourth", "fifth"][every] ?? `${every}th`} (${number.format(n)})`,
  onePhase: "Only one",
  phaseNumber: "Phase",
  phaseOf: (i: number, n: number) => `${number.format(i)} of ${number.format(n)}`,
  leftOut: (left: LeftOut) =>
    [
      left.doubles > 0 ? `${count(left.doubles, "duplicate", "duplicates")} skipped` : "",
      left.scouts > 0 ? `${count(left.scouts, "overview image", "overview images")} skipped` : "",
      left.others > 0 ? `${count(left.others, "slice", "slices")} of a different size skipped` : "",
      left.damaged > 0 ? `${count(left.damaged, "damaged slice", "damaged slices")} skipped` : "",
    ].filter((text) => text !== ""),
  resume: "Resume upload",
  resumeText: (percent: number) =>
    `The upload of this scan was interrupted at ${percent}%. It will resume where it stopped.`,
  sentElsewhere: "This scan is already being uploaded in another window of this browser.",
  storageFull: "The server has run out of space, so nothing was uploaded. Try again later.",
  repair: (repair: Repair) => {
    switch (repair.kind) {
      case "straightened":
        return `scanned at an angle; the tilt of ${repair.degrees.toFixed(1)}° will be corrected`;
      case "filled_in":
        return `${count(repair.slices, "missing slice", "missing slices")} will be filled in from the neighbouring ones`;
      case "varying":
        return `slices are ${repair.fromMm.toFixed(1)} to ${repair.toMm.toFixed(1)} mm apart, so small details may look blurred`;
      case "incomplete_phases":
        return `${count(repair.phases, "incomplete phase", "incomplete phases")} will be left out`;
      case "uncommon":
        return `${count(repair.slices, "slice", "slices")} that not every phase has will be left out`;
      case "fewer_phases":
        return `only ${number.format(repair.kept)} of ${number.format(repair.of)} phases will be uploaded, because all of them would be too large`;
      case "unknown_directions":
        return "the file doesn’t say which side is left or right, so the picture may be a mirror image";
    }
  },
  notSlices: (n: number) =>
    `${n === 1 ? "1 file is not an image slice" : `${number.format(n)} files are not image slices`} (for example, reports, screenshots or treatment plans).`,
  onlyReports:
    "This folder contains only reports or screenshots, but no image slices. Ask the hospital for the images of the scan in DICOM format.",
  overQuota: (needs: string, free: string) =>
    `This scan needs ${needs} of storage, but you have only ${free} left. Delete another scan first.`,
  tooLarge: "This scan is too large for this server.",
  reasons,
} as const;
