import type { StallReason } from "../../api/upload";
import type { UploadRefusal } from "../../api/upload_view";
import type { Correction, Note } from "../../scan/corrections";
import { count, fixed, number } from "./counting";

const corrected: Record<Exclude<Correction, "directions">, string> = {
  tilt: "it was tilted",
  spacing: "its slices were unevenly spaced",
  missing: "some slices were missing",
  duplicates: "it contained duplicates",
  overview: "it contained overview images",
  size: "some slices had a different size",
  damaged: "some files were damaged",
  brightness: "its slices had different brightness scales",
  phases: "some of its phases were incomplete, or there were too many",
  negative: "it was stored as a negative",
  scaled: "its values were outside the range that we store",
};

const list = new Intl.ListFormat("en-GB");

/** My scans: the cards and their actions. */
export const scans = {
  leadEmpty: "Add a scan from the folder, disc or file that your hospital gave you.",
  empty: "No scans yet",
  add: "Add a scan",
  list: "Your scans",
  order: "Sort by",
  orders: { added: "Newest upload first", date: "Date in the title", title: "Title", size: "Size" },
  examples: "Examples",
  used: (used: string, all: string) => `${used} of ${all} used`,
  untitledOn: (date: string) => `Untitled scan, ${date}`,
  addedOn: (date: string) => `added on ${date}`,
  rename: (title: string) => `Rename ${title}`,
  renameTitle: "Rename this scan",
  renameSave: "Save",
  /** Translated titles of the samples that come with Diaphane, by their stored titles. */
  sampleTitles: { Cranium: "Skull", Head: "Head", "Brain of a macaque": "Brain of a macaque" } as Readonly<
    Record<string, string>
  >,
  sampleTitle: "Sample scan",
  sample: "Sample",
  shared: "Public",
  open: (title: string) => `Open ${title}`,
  remove: (title: string) => `Delete ${title}`,
  removeTitle: "Delete this scan?",
  removeText: (title: string) =>
    `This will permanently delete “${title}” and everything made from it. Your own copy on the disc is not affected.`,
  removeYes: "Delete",
  upload: {
    sending: (percent: number, left: string) => (left ? `${percent}%, ${left}` : `${percent}%`),
    waiting: "Waiting for other uploads to finish.",
    paused: (percent: number) => `Paused at ${percent}%.`,
    elsewhere: (percent: number) => `${percent}%, in another window.`,
    stalled: {
      connection: "The connection was lost. The upload will resume automatically.",
      storage_full:
        "The server has run out of space. What you have uploaded so far is kept, and we’ll try again every minute.",
    } satisfies Record<StallReason, string>,
    refused: {
      expired: "The upload was inactive for too long and has expired. Delete it and upload the scan again.",
      gone: "This upload was deleted, here or on another device.",
      too_large: "This scan is too large for this server.",
      signed_out:
        "You were signed out. Sign in and choose the same folder again to resume the upload where it stopped.",
      other: "The server rejected the upload. Delete it and try again.",
    } satisfies Record<UploadRefusal, string>,
    pause: "Pause",
    resume: "Resume",
    pauseOf: (title: string) => `Pause the upload of ${title}`,
    resumeOf: (title: string) => `Resume the upload of ${title}`,
    left: (seconds: number) =>
      seconds < 50
        ? "less than a minute left"
        : seconds < 3300
          ? `about ${count(Math.round(seconds / 60), "minute", "minutes")} left`
          : `about ${count(Math.round(seconds / 3600), "hour", "hours")} left`,
    all: (uploads: number, percent: number) => `${count(uploads, "upload", "uploads")}, ${percent}%`,
  },
  interrupted: (percent: number) => `Interrupted at ${percent}%`,
  interruptedHint:
    "Choose the same folder again to resume the upload where it stopped. To protect your files, the browser can’t reopen the folder by itself.",
  resumeInterrupted: "Resume",
  cancelUpload: (title: string) => `Cancel the upload of ${title}`,
  cancelTitle: "Cancel this upload?",
  cancelText: (title: string) =>
    `Everything uploaded so far for “${title}” will be deleted immediately. Your own copy on the disc is not affected.`,
  cancelYes: "Cancel upload",
  cancelNo: "Keep uploading",
  serverAway: "The Diaphane server can’t be reached at the moment. Your scans are safe, and this page keeps trying.",
  states: {
    uploading: "Uploading",
    queued: "Waiting",
    building: "Preparing",
    ready: "Ready",
    refused: "Can’t be shown",
    expired: "Upload expired",
  },
  waitingFor: {
    room: "The server doesn’t have room for this scan at the moment. Your scan is safe, and processing will continue automatically as soon as there is room.",
    memory:
      "The server doesn’t have enough memory for this scan at the moment. Your scan is safe, and processing will continue automatically.",
    service:
      "Part of the server is unavailable at the moment. Your scan is safe, and processing will continue automatically.",
    interruption:
      "Processing was interrupted several times. Your scan is safe, and processing will start again automatically after a pause.",
  },
  expiredHint: "The upload wasn’t finished in time. Delete it and upload the scan again.",
  repaired: (what: readonly Correction[]) => {
    const named = what.flatMap((one) => (one === "directions" ? [] : corrected[one]));
    const unsure = "The file doesn’t say which side is left or right, so the picture may be a mirror image.";
    if (named.length > 0)
      return `We corrected this scan: ${list.format(named)}.${what.includes("directions") ? ` ${unsure}` : ""}`;
    return what.includes("directions") ? unsure : "We corrected this scan.";
  },
  phases: (n: number) => count(n, "phase", "phases"),
  repairDetails: "Details",
  repairNote: (note: Note): string => {
    switch (note.kind) {
      case "tilt":
        return `Gantry tilt of ${fixed(note.degrees, 1)}° corrected.`;
      case "spacing":
        return `Slice spacing varied from ${fixed(note.fromMm, 2)} to ${fixed(note.toMm, 2)} mm and was resampled to ${fixed(note.usedMm, 2)} mm, so small details may be blurred.`;
      case "positions":
        return `Slice positions deviated by up to ${fixed(note.mm, 2)} mm. The mean spacing was used.`;
      case "missing":
        return `${count(note.count, "slice was", "slices were")} missing and interpolated from the neighbouring slices.`;
      case "duplicates":
        return `${count(note.count, "duplicate slice was", "duplicate slices were")} skipped.`;
      case "overview":
        return `${count(note.count, "overview image was", "overview images were")} skipped.`;
      case "incomplete":
        return `${count(note.count, "incomplete phase was", "incomplete phases were")} left out.`;
      case "uncommon":
        return `${count(note.count, "slice", "slices")} at the ends of some phases ${note.count === 1 ? "was" : "were"} left out, because other phases don’t have them.`;
      case "fewer":
        return `Only ${number.format(note.kept)} of ${number.format(note.of)} phases were kept, because all of them would be larger than allowed.`;
      case "size":
        return `${count(note.count, "slice of a different size was", "slices of a different size were")} skipped.`;
      case "damaged":
        return `${count(note.count, "damaged or unreadable file was", "damaged or unreadable files were")} skipped.`;
      case "clipped":
        return `Values above ${number.format(note.limit)} were clipped.`;
      case "scaled":
        return `Values were multiplied by ${number.format(note.factor)} for storage.`;
      case "directions":
        return "The file doesn’t say how the scan lies in the body, so left and right may be swapped.";
      case "halved":
        return "Values were halved for storage.";
      case "brightness":
        return "The slices had different value scales and were converted to a single one.";
      case "negative":
        return "The negative was converted back to a positive image.";
    }
  },
  picture: (title: string) => `Picture of ${title}`,
  pictureBeingMade: "The picture is being made.",
  noPicture: "No picture yet.",
} as const;
