/** Returns the values of an inflated ExactSlice.data (api/proto/stream.proto). @throws if it has a different size. */
export function valuesOf(bytes: Uint8Array, columns: number, rows: number): Int16Array<ArrayBuffer> {
  const pixels = columns * rows;
  if (bytes.length !== 2 * pixels) throw new Error("a slice of another size");
  const values = new Int16Array(pixels);
  for (let i = 0; i < pixels; ++i) values[i] = (bytes[i] ?? 0) | ((bytes[pixels + i] ?? 0) << 8);
  return values;
}

/** Checks an inflated ExactSlice.labels. @throws if it has a different size. */
export function labelsOf(bytes: Uint8Array<ArrayBuffer>, columns: number, rows: number): Uint8Array<ArrayBuffer> {
  if (bytes.length !== columns * rows) throw new Error("labels of another size");
  return bytes;
}

/** Inflates zlib data with the browser's own decoder. @throws on invalid data. */
export async function inflate(data: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
  const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

export const canInflate = (): boolean => typeof DecompressionStream === "function";
