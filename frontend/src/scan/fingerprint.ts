import type { SliceHeader } from "./types";

/**
 * Returns a number that identifies the same files after a reload, so that their upload can be
 * resumed. Only this number is stored. It reveals no name and no identifier.
 */
export function fingerprint(slices: readonly SliceHeader[]): string {
  return fingerprintOf(codesOf(slices));
}

function* codesOf(slices: readonly SliceHeader[]): Iterable<number> {
  for (const slice of slices) {
    const text = `${slice.sopUid} ${slice.fileBytes};`;
    for (let i = 0; i < text.length; i++) yield text.charCodeAt(i);
  }
}

export function fingerprintOf(codes: Iterable<number>): string {
  let low = 0xdeadbeef;
  let high = 0x41c6ce57;
  for (const code of codes) {
    low = Math.imul(low ^ code, 2654435761);
    high = Math.imul(high ^ code, 1597334677);
  }
  low = Math.imul(low ^ (low >>> 16), 2246822507) ^ Math.imul(high ^ (high >>> 13), 3266489909);
  high = Math.imul(high ^ (high >>> 16), 2246822507) ^ Math.imul(low ^ (low >>> 13), 3266489909);
  return (high >>> 0).toString(16).padStart(8, "0") + (low >>> 0).toString(16).padStart(8, "0");
}
