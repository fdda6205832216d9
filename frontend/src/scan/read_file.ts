import { deflated_from, read_header, type HeaderRead } from "./dicom";
import type { SliceHeader } from "./types";

/** 64 KB hold nearly every header; then 256 KB; then the whole file, up to a bound that no header reaches. */
const steps = [64 * 1024, 256 * 1024, 64 * 1024 * 1024];
const inflated_limit = 1024 * 1024;

/** Never throws: a bad file must not stop the scan. */
export async function read_file_header(file: Blob, index: number): Promise<HeaderRead> {
  try {
    for (const step of steps) {
      const size = Math.min(step, file.size);
      const bytes = new Uint8Array(await file.slice(0, size).arrayBuffer());
      const deflated = deflated_from(bytes);
      const inflated = deflated === null ? undefined : await inflate(bytes.subarray(deflated));
      const read = read_header(bytes, index, file.size, inflated);
      if (read.kind === "header") return { kind: "header", header: await with_end_of_fragments(file, read.header) };
      if (read.kind !== "more") return read;
      if (size === file.size) break;
    }
  } catch {
    // Not readable on disk, or nested without end.
  }
  return { kind: "unreadable" };
}

const most_fragments = 10_000;

/** Compressed voxels end where their last fragment does; what comes behind it is not sent. */
async function with_end_of_fragments(file: Blob, header: SliceHeader): Promise<SliceHeader> {
  const voxels = header.voxels;
  if (!voxels?.encapsulated) return header;
  let at = voxels.from;
  for (let i = 0; i < most_fragments && at + 8 <= file.size; i++) {
    const item = new DataView(await file.slice(at, at + 8).arrayBuffer());
    const length = item.getUint32(4, true);
    if (item.getUint16(0, true) !== 0xfffe) break;
    if (item.getUint16(2, true) === 0xe0dd) return { ...header, voxels: { ...voxels, to: at + 8 } };
    at += 8 + length;
  }
  return { ...header, voxels: null, truncated: true };
}

/** The beginning of the inflated bytes: bounded, whatever the file promises. */
async function inflate(bytes: Uint8Array): Promise<Uint8Array> {
  const out = new Uint8Array(inflated_limit);
  let filled = 0;
  const stream = new Blob([new Uint8Array(bytes)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const reader = stream.getReader();
  try {
    while (filled < out.length) {
      const { done, value } = await reader.read();
      if (done) break;
      const part = value.subarray(0, out.length - filled);
      out.set(part, filled);
      filled += part.length;
    }
  } catch {
    // The end of the file was cut off: what came before it is used.
  }
  await reader.cancel().catch(() => undefined);
  return out.subarray(0, filled);
}
