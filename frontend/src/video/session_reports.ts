import { SliceAccess } from "../protocol/messages";
import type { Access } from "../slices/model";
import { t } from "../texts";
import { serverSentence } from "../texts/problem_text";

export const sliceAccess: Readonly<Record<SliceAccess, Access>> = {
  [SliceAccess.NONE]: "none",
  [SliceAccess.SHOWN]: "shown",
  [SliceAccess.CLIPPED]: "clipped",
  [SliceAccess.WHOLE]: "whole",
};

/** Returns the sentence for an input that the server rejected. */
export function problemText(field: string, message: string): string {
  if (field === "own_camera") return t.live.noFreeCamera;
  if (field === "own_camera_taken") return t.live.freeCameraTaken;
  return serverSentence(message, t.problems.notTaken);
}
