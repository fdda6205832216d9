import { readAtMost } from "../streams";
import { crc32 } from "./crc32";

/** A file to read: a chosen one, or one within an archive. It can be handed to another thread without copying. */
export interface Piece {
  /** Length of the file in bytes. */
  readonly size: number;
  /** The file, or the part of the archive that contains it. */
  readonly blob: Blob;
  /**
   * The file's entry in a ZIP archive, where `blob` begins with the local header. Null if `blob` is
   * the file.
   */
  readonly zipped: Zipped | null;
}

export interface Zipped {
  readonly isDeflated: boolean;
  readonly packedSize: number;
  readonly crc32: number;
}

export const pieceOf = (blob: Blob): Piece => ({ size: blob.size, blob, zipped: null });

/** Thrown if a file in an archive does not match its entry. */
export class DamagedPiece extends Error {}

/** Margin for data that Deflate cannot compress, to which it adds a few bytes per 16 KB. */
const slack = 64 * 1024;

/** Reads the first bytes of a file, without unpacking the rest. Throws DamagedPiece. */
export async function beginningOf(piece: Piece, most: number): Promise<Uint8Array<ArrayBuffer>> {
  const size = Math.min(most, piece.size);
  if (!piece.zipped) return bytesOf(piece.blob.slice(0, size));
  // Reads all at once, because each read takes the browser about two milliseconds.
  const { isDeflated, packedSize } = piece.zipped;
  const read = await bytesOf(piece.blob.slice(0, 2 * size + 2 * slack));
  const begin = dataBegin(new DataView(read.buffer));
  const packed = read.subarray(begin, begin + packedSize);
  const { bytes } = isDeflated
    ? await readAtMost(inChunks(packed).pipeThrough(new DecompressionStream("deflate-raw")), size)
    : { bytes: packed.slice(0, size) };
  if (bytes.length < size) throw new DamagedPiece();
  return bytes;
}

/**
 * Streams bytes in small chunks of the same size, so that a stream behind it can be cancelled before
 * its input, which may be cut off, ends.
 */
export function inChunks(bytes: Uint8Array<ArrayBuffer>): ReadableStream<Uint8Array<ArrayBuffer>> {
  let at = 0;
  return new ReadableStream({
    pull(controller) {
      if (at >= bytes.length) controller.close();
      else controller.enqueue(bytes.subarray(at, (at += slack / 4)));
    },
  });
}

/** Returns the file, which is decompressed and checked if necessary. Throws DamagedPiece. */
export async function wholeOf({ blob, size, zipped }: Piece): Promise<Blob> {
  if (!zipped) return blob;
  const packed = await packedOf(blob, zipped);
  if (!zipped.isDeflated) return packed;
  let sum = 0;
  const whole = await collected(inflated(packed), size, (bytes) => (sum = crc32(bytes, sum)));
  if (whole?.size !== size || sum !== zipped.crc32) throw new DamagedPiece();
  return whole;
}

/** Returns what a stream delivers, or null if it breaks or delivers more than `most` bytes. */
export async function collected(
  stream: ReadableStream<Uint8Array<ArrayBuffer>>,
  most: number,
  look: (bytes: Uint8Array) => void = () => undefined,
): Promise<Blob | null> {
  let length = 0;
  const bounded = new TransformStream<Uint8Array<ArrayBuffer>, Uint8Array<ArrayBuffer>>({
    transform(bytes, controller) {
      length += bytes.length;
      look(bytes);
      if (length > most) controller.error(new RangeError("more than expected"));
      else controller.enqueue(bytes);
    },
  });
  try {
    // The browser can move this Blob to the disk while it grows, unlike a Blob of parts.
    return await new Response(stream.pipeThrough(bounded)).blob();
  } catch {
    return null;
  }
}

const bytesOf = async (blob: Blob) => new Uint8Array(await blob.arrayBuffer());
const inflated = (packed: Blob) => packed.stream().pipeThrough(new DecompressionStream("deflate-raw"));

/** Length of a local file header without its name and extra field, whose lengths are in its last four bytes. */
const headerLength = 30;
const headerSignature = 0x04034b50;

/** Returns the data behind the local header, whose length is known only from the header itself. */
async function packedOf(blob: Blob, { packedSize }: Zipped): Promise<Blob> {
  const begin = dataBegin(new DataView(await blob.slice(0, headerLength).arrayBuffer()));
  const packed = blob.slice(begin, begin + packedSize);
  if (packed.size < packedSize) throw new DamagedPiece();
  return packed;
}

/** Returns where the data behind a local header begins. */
function dataBegin(header: DataView): number {
  if (header.byteLength < headerLength || header.getUint32(0, true) !== headerSignature) throw new DamagedPiece();
  return headerLength + header.getUint16(26, true) + header.getUint16(28, true);
}

/** The longest local header that a ZIP archive can have. */
export const longestLocalHeader = headerLength + 2 * 0xffff;
