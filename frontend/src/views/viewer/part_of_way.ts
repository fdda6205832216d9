import { stopOf, type Effort } from "../../scene/effort";
import { partDone, renderersError } from "../../video/still_shot";
import type { PictureFacts } from "../../video/picture_facts";

/**
 * Returns the fraction of its samples that a picture has, from 0 to 1, depending on the stop condition. Null while it
 * is unknown.
 */
export function refinementProgress(
  { error, samples }: Pick<PictureFacts, "error" | "samples">,
  effort: Effort,
): number | null {
  const most = 0.99; // a picture that is not finished never shows 100%
  const part =
    stopOf(effort) === "samples" ? samples / effort.stop_samples : partDone(error, effort.stop_error || renderersError);
  return part === null ? null : Math.min(most, part);
}
