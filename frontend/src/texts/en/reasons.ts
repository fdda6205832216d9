import type { Reason } from "../../scan/types";
import { count, number } from "./counting";

/** Why a series cannot be shown, for a patient. */
export const reasons: Record<Reason, (n: number) => string> = {
  no_slices: () => "These are no slices of a CT, MR or PET scan.",
  screenshots: () => "These are screenshots, not slices of a scan.",
  scout: () => "This is a scout: a picture that the scan was planned by.",
  views_not_slices: () => "These are views of a scan from many sides, not slices.",
  not_original: () => "These pictures were computed from a scan; only original slices are accepted.",
  no_position: () => "The files do not say where each picture lies in the body.",
  no_spacing: () => "The files do not say how large the pictures are.",
  bad_orientation: () => "The files say something impossible about how the pictures lie in the body.",
  one_position: () => "All pictures show the same place at different times: there is no depth to show.",
  cine: () => "This is a film of one place: there is no depth to show.",
  repeated_position: () => "Some places were taken twice, and it is not known which picture counts.",
  repeated_identifier: () => "Different pictures carry the same number, so some may be lost. Ask the hospital for a new copy.",
  time_series: () => "The same part of the body was taken several times (contrast phases, echoes or weightings). Such a series cannot be shown yet.",
  mixed: () => "Pictures of different sizes or directions are mixed here, with too few of each kind.",
  lookup_table: () => "The brightness of these pictures is coded in a way that is not supported.",
  bad_rescale: () => "The files say something impossible about the brightness of the pictures.",
  no_rescale: () => "The files do not say what the brightness of the pictures means.",
  pixel_format: () => "The pictures are stored in a form that is not supported.",
  missing_slices: (n) => `${count(n, "slice is", "slices are")} missing within the series; copy the disc again.`,
  varying_spacing: () => "The distance from slice to slice varies too much for a picture that is true.",
  shifted_slices: () => "Some slices are shifted sideways against the others.",
  tilted: () => "The slices are shifted against each other too far.",
  unsupported_compression: () => "The pictures are compressed in a way that is not supported.",
  damaged: () => "The files end too early: the disc may be damaged. Copy it again.",
  too_few_slices: (n) => `Too few slices: ${number.format(n)}, and 16 are needed to show depth.`,
  too_short: (n) => `Too few slices: together they are ${number.format(n)} mm high, and 20 mm are needed.`,
  too_large: () => "This series is larger than can be taken here: a file may have 1 GB, and a scan 1024 × 1024 × 1024 points.",
};
