/** ExactSlice.data once inflated (api/proto/stream.proto). @throws when it is not of that size. */
export function valuesOf(bytes: Uint8Array, columns: number, rows: number): Int16Array<ArrayBuffer> {
  const pixels = columns * rows;
  if (bytes.length !== 2 * pixels) throw new Error("a slice of another size");
  const values = new Int16Array(pixels);
  for (let i = 0; i < pixels; ++i) values[i] = (bytes[i] ?? 0) | ((bytes[pixels + i] ?? 0) << 8);
  return values;
}

/** zlib, by the browser itself. @throws on what is none. */
export async function inflate(data: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
  const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

export const canInflate = (): boolean => typeof DecompressionStream === "function";
