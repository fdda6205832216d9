/**
 * Returns the SHA-256 hash. Uses the browser's implementation in a secure context, and otherwise
 * one in software that is loaded on demand.
 */
export async function sha256(bytes: Uint8Array<ArrayBuffer>): Promise<Uint8Array> {
  const subtle = (globalThis.crypto as Crypto | undefined)?.subtle;
  if (subtle) return new Uint8Array(await subtle.digest("SHA-256", bytes));
  const { sha256: inSoftware } = await import("@noble/hashes/sha2.js");
  return inSoftware(bytes);
}
