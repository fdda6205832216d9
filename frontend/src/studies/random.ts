import { sha256 } from "@noble/hashes/sha2.js";

/**
 * Returns a source of uniform numbers in [0, 1) for one purpose of one participant. Number k is made of the first 52
 * bits of SHA-256("seed/purpose/k"), so that the analysis can compute it again in any language.
 */
export function randomNumbers(seed: number, purpose: string): () => number {
  let count = 0;
  return () => {
    const digest = sha256(new TextEncoder().encode(`${seed}/${purpose}/${count++}`));
    const words = new DataView(digest.buffer, digest.byteOffset);
    return (words.getUint32(0) * 2 ** 20 + (words.getUint32(4) >>> 12)) / 2 ** 52;
  };
}

/** Returns the items in random order (Fisher and Yates). */
export function shuffled<Item>(items: readonly Item[], random: () => number): Item[] {
  const result = [...items];
  for (let i = result.length - 1; i > 0; --i) {
    const j = Math.floor(random() * (i + 1));
    const [a, b] = [result[i], result[j]];
    if (a === undefined || b === undefined) continue;
    result[i] = b;
    result[j] = a;
  }
  return result;
}
