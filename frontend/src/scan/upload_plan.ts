import { pauses } from "./pause";
import type { UploadPart, UploadPlan } from "./types";

/** Packed, so that a worker gives thousands of parts to the page as a few buffers. */
export function plan_of(parts: readonly UploadPart[]): UploadPlan {
  const heads = new Uint8Array(parts.reduce((sum, { head }) => sum + head.length, 0));
  const head_ends = new Uint32Array(parts.length);
  let at = 0;
  parts.forEach(({ head }, i) => {
    heads.set(head, at);
    at += head.length;
    head_ends[i] = at;
  });
  return {
    heads,
    head_ends,
    files: Uint32Array.from(parts, ({ file }) => file),
    froms: Float64Array.from(parts, ({ from }) => from),
    tos: Float64Array.from(parts, ({ to }) => to),
    inflated: new Map(parts.flatMap(({ file, inflated }) => (inflated ? [[file, inflated] as const] : []))),
  };
}

/** What goes to another thread without being copied. */
export const buffers_of = ({ heads, head_ends, files, froms, tos }: UploadPlan): ArrayBuffer[] =>
  [heads, head_ends, files, froms, tos].map((array) => array.buffer);

/** Bytes of each part. */
export const sizes_of = (plan: UploadPlan): number[] => Array.from(plan.files, (_, i) => head_of(plan, i).length + span_of(plan, i));

/** The bytes to send of each part, read only when they are sent. In steps: each costs the browser about a millisecond. */
export async function part_blobs(plan: UploadPlan, files: readonly Blob[]): Promise<Blob[]> {
  const pause = pauses();
  const blobs: Blob[] = [];
  for (const [i, file] of plan.files.entries()) {
    const source = plan.inflated.get(file) ?? files[file];
    const from = plan.froms[i] ?? 0;
    if (source) blobs.push(new Blob([head_of(plan, i), source.slice(from, from + span_of(plan, i))]));
    await pause();
  }
  return blobs;
}

const head_of = ({ heads, head_ends }: UploadPlan, i: number) => heads.subarray(head_ends[i - 1] ?? 0, head_ends[i]);
const span_of = ({ froms, tos }: UploadPlan, i: number) => (tos[i] ?? 0) - (froms[i] ?? 0);
