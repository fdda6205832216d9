import { readAtMost } from "../streams";
import { archiveFormat } from "./archives";
import { deflatedFrom, readHeader, type HeaderRead } from "./dicom";
import { readImage } from "./image/read_image";
import { beginningOf, wholeOf, type Piece } from "./piece";
import type { SliceHeader } from "./types";

/**
 * Numbers of bytes to read. 8 KB contain most CT headers, and 64 KB nearly all. The last one is a
 * limit that no header reaches.
 */
const steps = [8 * 1024, 64 * 1024, 256 * 1024, 64 * 1024 * 1024];
/** The largest initial step, even if the previous file needed a larger one. */
const mostAtOnce = 2;
/** The server's limit for inflated data (ingest/dicom/precheck.h). */
const inflatedLimit = (packed: number) => Math.min(2 ** 28, 2 ** 24 + 32 * packed);

/** Reads the headers of a disc one after the other. Those of a series have the same length. */
export class HeaderReader {
  /** The step that was sufficient for the previous file. */
  private usual = 0;

  /** Reads the header of a file. Never throws, because a bad file must not stop the scan. */
  async read(file: Piece, index: number): Promise<HeaderRead> {
    try {
      for (let step = this.usual; step < steps.length; step++) {
        const size = Math.min(steps[step] ?? 0, file.size);
        const bytes = await beginningOf(file, size);
        const image = readImage(bytes);
        if (image === "more" && size < file.size) continue;
        if (image !== null && image !== "more") return { kind: "image", header: image };
        const deflated = deflatedFrom(bytes);
        if (deflated !== null) return await readDeflated((await wholeOf(file)).slice(deflated), index);
        const read = readHeader(bytes, index, file.size);
        if (read.kind === "headers") {
          const [{ voxels } = { voxels: null }] = read.headers;
          const used = voxels?.from ?? 0;
          this.usual = Math.min(
            mostAtOnce,
            steps.findIndex((enough) => used < enough),
          );
          return { kind: "headers", headers: await withEndOfFragments(file, bytes, read.headers) };
        }
        if (read.kind === "not_dicom") {
          const format = archiveFormat(bytes);
          return format ? { kind: "archive", format } : read;
        }
        if (read.kind !== "more") return read;
        if (size === file.size) break;
      }
    } catch {
      // The file is not readable on disk, damaged in its archive, or its elements are nested too deeply.
    }
    return { kind: "unreadable" };
  }
}

/** Inflates the file. The result has no file header and is what is sent. */
async function readDeflated(packed: Blob, index: number): Promise<HeaderRead> {
  // Of a truncated file, the part that exists is used. A file that inflates too far is refused,
  // because its last slices would be missing.
  const { bytes, end } = await readAtMost(
    packed.stream().pipeThrough(new DecompressionStream("deflate-raw")),
    inflatedLimit(packed.size),
  );
  if (end === "more") return { kind: "unreadable" };
  const read = readHeader(bytes, index, bytes.length);
  if (read.kind !== "headers") return { kind: "unreadable" };
  const inflated = new Blob([bytes]);
  return { kind: "headers", headers: read.headers.map((header) => ({ ...header, inflated })) };
}

const mostFragments = 100_000;

/**
 * Finds the end of compressed voxels, which is that of their last fragment. What follows is not
 * sent.
 */
async function withEndOfFragments(
  piece: Piece,
  begin: Uint8Array<ArrayBuffer>,
  headers: readonly SliceHeader[],
): Promise<readonly SliceHeader[]> {
  const voxels = headers[0]?.voxels;
  if (!voxels?.encapsulated) return headers;
  const file = await wholeOf(piece);
  let at = voxels.from;
  for (let i = 0; i < mostFragments && at + 8 <= file.size; i++) {
    // A read costs about one millisecond, so the bytes that are already there are used first.
    const there = at + 8 <= begin.length;
    const item = there ? new DataView(begin.buffer, at, 8) : new DataView(await file.slice(at, at + 8).arrayBuffer());
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
