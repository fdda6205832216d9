import { deflated_from, read_header, type HeaderRead } from "./dicom";
import type { SliceHeader } from "./types";

/** 64 KB hold nearly every header; then 256 KB; then the whole file, up to a bound that no header reaches. */
const steps = [64 * 1024, 256 * 1024, 64 * 1024 * 1024];
const inflated_limit = 16 * 1024 * 1024;

/** Never throws: a bad file must not stop the scan. */
export async function read_file_header(file: Blob, index: number): Promise<HeaderRead> {
  try {
    for (const step of steps) {
      const size = Math.min(step, file.size);
      const bytes = new Uint8Array(await file.slice(0, size).arrayBuffer());
      const deflated = deflated_from(bytes);
      if (deflated !== null) return await read_deflated(file.slice(deflated), index, file.size);
      const read = read_header(bytes, index, file.size);
      if (read.kind === "headers") return { kind: "headers", headers: await with_end_of_fragments(file, read.headers) };
      if (read.kind !== "more") return read;
      if (size === file.size) break;
    }
  } catch {
    // Not readable on disk, or nested without end.
  }
  return { kind: "unreadable" };
}

/** What it unpacks to is a file of its own, without a header, and is what is sent. */
async function read_deflated(packed: Blob, index: number, file_bytes: number): Promise<HeaderRead> {
  const bytes = await inflate(packed);
  const read = read_header(bytes, index, bytes.length);
  if (read.kind !== "headers") return { kind: "unreadable" };
  const inflated = new Blob([bytes]);
  return { kind: "headers", headers: read.headers.map((header) => ({ ...header, file_bytes, inflated })) };
}

const most_fragments = 100_000;

/** Compressed voxels end where their last fragment does; what comes behind it is not sent. */
async function with_end_of_fragments(file: Blob, headers: readonly SliceHeader[]): Promise<readonly SliceHeader[]> {
  const voxels = headers[0]?.voxels;
  if (!voxels?.encapsulated) return headers;
  let at = voxels.from;
  for (let i = 0; i < most_fragments && at + 8 <= file.size; i++) {
    const item = new DataView(await file.slice(at, at + 8).arrayBuffer());
    const length = item.getUint32(4, true);
    if (item.getUint16(0, true) !== 0xfffe) break;
    if (item.getUint16(2, true) === 0xe0dd) {
      const found = { ...voxels, to: at + 8 };
      return headers.map((header) => ({ ...header, voxels: found }));
    }
    at += 8 + length;
  }
  return headers.map((header) => ({ ...header, voxels: null, truncated: true }));
}

/** The inflated bytes: bounded, whatever the file promises. */
async function inflate(packed: Blob): Promise<Uint8Array<ArrayBuffer>> {
  const parts: Uint8Array[] = [];
  let length = 0;
  const reader = packed.stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader();
  try {
    while (length < inflated_limit) {
      const { done, value } = await reader.read();
      if (done) break;
      parts.push(value.subarray(0, inflated_limit - length));
      length += value.length;
    }
  } catch {
    // The end of the file was cut off: what came before it is used.
  }
  await reader.cancel().catch(() => undefined);
  const all = new Uint8Array(Math.min(length, inflated_limit));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}
