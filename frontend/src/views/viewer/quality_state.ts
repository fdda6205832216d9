import type { Effort } from "../../scene/effort";
import { t } from "../../texts";
import type { PictureFacts } from "../../video/picture_facts";
import { partOfWay } from "./part_of_way";

export interface QualityState {
  readonly finished: boolean;
  readonly text: string;
  /** The part of the samples that is done, where it is known and the picture is still being refined. */
  readonly part: number | null;
}

/** How far the picture is, in words for a patient. A denoised picture is on the same way as any other. */
export function qualityState(
  facts: Pick<PictureFacts, "error" | "samples">,
  effort: Effort,
  finished: boolean,
): QualityState {
  if (finished) return { finished, text: t.viewer.finished, part: null };
  const part = partOfWay(facts, effort);
  return { finished, text: t.viewer.refining(part), part };
}
