import { stopOf, type Effort } from "../../scene/effort";
import { partDone, renderersError } from "../../video/still_shot";
import type { PictureFacts } from "../../video/picture_facts";

/** The share of its samples that a picture has, 0 to 1, by where the renderer is to stop; nothing while that is unknown. */
export function partOfWay({ error, samples }: Pick<PictureFacts, "error" | "samples">, effort: Effort): number | null {
  const most = 0.99; // a picture that is not finished never reads 100%
  const part =
    stopOf(effort) === "samples" ? samples / effort.stop_samples : partDone(error, effort.stop_error || renderersError);
  return part === null ? null : Math.min(most, part);
}
