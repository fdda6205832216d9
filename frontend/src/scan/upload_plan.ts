import { pauses } from "./pause";
import { pieceOf, wholeOf, type Piece } from "./piece";
import type { UploadPart, UploadPlan } from "./types";

/** Packs thousands of parts into a few buffers, so that a worker can hand them to the page quickly. */
export function planOf(parts: readonly UploadPart[], isOneFile = false): UploadPlan {
  const heads = new Uint8Array(parts.reduce((sum, { head }) => sum + head.length, 0));
  const headEnds = new Uint32Array(parts.length);
  let at = 0;
  parts.forEach(({ head }, i) => {
    heads.set(head, at);
    at += head.length;
    headEnds[i] = at;
  });
  return {
    heads,
    headEnds,
    files: Uint32Array.from(parts, ({ file }) => file),
    froms: Float64Array.from(parts, ({ from }) => from),
    tos: Float64Array.from(parts, ({ to }) => to),
    inflated: new Map(parts.flatMap(({ file, inflated }) => (inflated ? [[file, inflated] as const] : []))),
    isOneFile,
  };
}

/** Returns the buffers that can be transferred to another thread without copying. */
export const buffersOf = ({ heads, headEnds, files, froms, tos }: UploadPlan): ArrayBuffer[] =>
  [heads, headEnds, files, froms, tos].map((array) => array.buffer);

/** Returns the parts of a plan, of which `planOf` makes the same plan. */
export const partsOf = (plan: UploadPlan): UploadPart[] =>
  Array.from(plan.files, (file, i) => {
    const from = plan.froms[i] ?? 0;
    return { file, head: headOf(plan, i), from, to: from + spanOf(plan, i), inflated: plan.inflated.get(file) ?? null };
  });

/** Returns the size of each file in bytes. */
export function sizesOf(plan: UploadPlan): number[] {
  const sizes = Array.from(plan.files, (_, i) => headOf(plan, i).length + spanOf(plan, i));
  return plan.isOneFile ? [sizes.reduce((sum, size) => sum + size, 0)] : sizes;
}

/**
 * Returns the contents of the files, which are read only when they are sent, unless an archive compresses them.
 * `unpacked`: ScanResult.unpacked. Works in steps, because each part costs about one millisecond. Throws DamagedPiece.
 */
export async function partBlobs(
  plan: UploadPlan,
  files: readonly Blob[],
  unpacked: readonly (Piece | null)[] = [],
): Promise<Blob[]> {
  const pause = pauses();
  const blobs: Blob[] = [];
  for (const [i, file] of plan.files.entries()) {
    const chosen = files[file];
    const piece = chosen ? pieceOf(chosen) : unpacked[file - files.length];
    const source = plan.inflated.get(file) ?? (piece && (await wholeOf(piece)));
    const from = plan.froms[i] ?? 0;
    if (source) blobs.push(new Blob([headOf(plan, i), source.slice(from, from + spanOf(plan, i))]));
    await pause();
  }
  return plan.isOneFile ? [new Blob(blobs)] : blobs;
}

const headOf = ({ heads, headEnds }: UploadPlan, i: number) => heads.subarray(headEnds[i - 1] ?? 0, headEnds[i]);
const spanOf = ({ froms, tos }: UploadPlan, i: number) => (tos[i] ?? 0) - (froms[i] ?? 0);
