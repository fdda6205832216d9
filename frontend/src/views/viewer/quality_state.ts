import type { Effort } from "../../scene/effort";
import { t } from "../../texts";
import type { PictureFacts } from "../../video/picture_facts";
import { refinementProgress } from "./part_of_way";

export interface QualityState {
  readonly finished: boolean;
  readonly text: string;
  /** The part of the samples that is done, where it is known and the picture is still being refined. */
  readonly part: number | null;
}

/**
 * Returns the progress of the picture, in words for a patient. A denoised picture counts like any
 * other.
 */
export function qualityState(
  facts: Pick<PictureFacts, "error" | "samples">,
  effort: Effort,
  finished: boolean,
): QualityState {
  if (finished) return { finished, text: t.viewer.finished, part: null };
  const part = refinementProgress(facts, effort);
  return { finished, text: t.viewer.refining(part), part };
}
