import type { LateReason, Reason } from "../../scan/types";
import { count, number } from "./counting";

/** Why a series can't be shown, in words for patients. */
export const reasons: Record<Reason | LateReason, (n: number) => string> = {
  no_slices: () => "This series contains no CT, MR or PET slices.",
  screenshots: () => "These are screenshots, not slices of a scan.",
  scout: () => "This is an overview image that was used to plan the scan.",
  views_not_slices: () => "These images show a scan from many sides. They are not slices.",
  not_original: () => "These images were computed from a scan. Only the original slices can be shown.",
  no_position: () => "The files don’t say where in the body each image belongs.",
  no_spacing: () =>
    "The files don’t say how large the images are in millimetres, or the size they give can’t be right.",
  bad_orientation: () => "The files contain impossible information about how the images lie in the body.",
  one_position: () => "All images show the same place at different times, so there is no depth to show.",
  cine: () => "This is a video of a single place in the body, so there is no depth to show.",
  repeated_position: () => "Some places were scanned twice, and we can’t tell which image is the right one.",
  repeated_identifier: () =>
    "Different images have the same number, so some may have been lost. Ask the hospital for a new copy.",
  incomplete_phases: () =>
    "The same part of the body was scanned several times, but slices of most of these scans are missing. Try copying the files from the disc again.",
  time_series: () =>
    "The same part of the body was scanned several times (contrast phases, echoes or weightings). Such series can’t be shown yet.",
  mixed: () => "This series mixes images of different kinds, sizes or directions.",
  lookup_table: () => "The brightness of these images is stored in a way that isn’t supported.",
  bad_rescale: () => "The files contain impossible values for the brightness of the images.",
  no_rescale: () => "The files don’t say what the brightness of the images means.",
  pixel_format: () => "The images are stored in a format that isn’t supported.",
  missing_slices: (n) =>
    `${count(n, "slice is", "slices are")} missing from this series. Try copying the files from the disc again.`,
  varying_spacing: () => "The gaps between the slices vary too much for an accurate picture.",
  shifted_slices: () => "Some slices are shifted sideways relative to the others.",
  tilted: () => "The slices are shifted too far relative to each other.",
  unsupported_compression: () => "The images are compressed in a way that isn’t supported.",
  damaged: () => "The files are incomplete, and the disc may be damaged. Try copying the files from the disc again.",
  no_voxels: () => "The image data is in a second file. Choose both files together.",
  too_few_slices: (n) =>
    `There ${n === 1 ? "is only 1 slice" : `are only ${number.format(n)} slices`}. At least 16 are needed to show depth.`,
  too_short: (n) => `The slices cover only ${number.format(n)} mm of the body. At least 20 mm are needed.`,
  too_large: () => "This series is too large. The limits are 1 GB per file and 1024 × 1024 × 1024 points per scan.",
  over_quota: () => "You don’t have enough storage left for this scan. Delete other scans, then upload this one again.",
  values_out_of_range: () => "The values of this scan are stored in a form that isn’t supported.",
  no_memory: () =>
    "The server ran out of memory or time each time it processed this scan, although the scan is within the limits. Upload it again later, or contact the administrator of this server.",
  upload_gone: () => "The upload is no longer available. Upload the scan again.",
};
