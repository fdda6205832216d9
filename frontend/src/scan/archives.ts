import { ZipReader, type Reader } from "@zip.js/zip.js/lib/zip-core-reader.js";
import { collected, longestLocalHeader, pieceOf, type Piece } from "./piece";

/** The only file that uses zip.js. It reads the directory of an archive; the browser itself unpacks. */

export type ArchiveFormat = "zip" | "gzip" | "tar" | "other";

/**
 * Why an archive, or a part of it, cannot be read: it needs a password, is damaged, contains archives in archives in
 * archives, unpacks to more than is allowed, or has a format or a compression that browsers do not know.
 */
export type ArchiveFault = "encrypted" | "damaged" | "nested" | "large" | "format";

/**
 * Limits on what the archives of one choice unpack to, so that a small file cannot fill the memory
 * or the disk.
 */
export class Budget {
  constructor(
    private files = 100_000,
    private bytes = 8 * 2 ** 30,
  ) {}

  takeFile(): boolean {
    return this.files-- > 0;
  }

  get bytesLeft(): number {
    return this.bytes;
  }

  /** Counts unpacked bytes that are kept. Those that are only searched need no memory. */
  takeBytes(count: number): void {
    this.bytes -= count;
  }
}

/** First entries of programs and documents that happen to be ZIP archives, such as Java programs and Word files. */
const noScans = ["META-INF/", "[Content_Types].xml", "_rels/", "mimetype", "AndroidManifest.xml"];

/** Recognises an archive by its first bytes, whatever its name. */
export function archiveFormat(begin: Uint8Array): ArchiveFormat | null {
  const has = (at: number, ...wanted: readonly number[]) => wanted.every((byte, i) => begin[at + i] === byte);
  if (has(0, 0x50, 0x4b, 5, 6)) return "zip"; // an archive without files
  if (has(0, 0x50, 0x4b, 3, 4)) {
    const first = String.fromCharCode(...begin.subarray(30, 60));
    return noScans.some((name) => first.startsWith(name)) ? null : "zip";
  }
  if (has(0, 0x1f, 0x8b, 8)) return "gzip";
  if (has(257, 0x75, 0x73, 0x74, 0x61, 0x72)) return "tar";
  const isRar = has(0, 0x52, 0x61, 0x72, 0x21, 0x1a, 7);
  const is7z = has(0, 0x37, 0x7a, 0xbc, 0xaf, 0x27, 0x1c);
  const isBzip2 = has(0, 0x42, 0x5a, 0x68) && has(4, 0x31, 0x41, 0x59, 0x26, 0x53, 0x59);
  const isXz = has(0, 0xfd, 0x37, 0x7a, 0x58, 0x5a, 0);
  const isZstd = has(0, 0x28, 0xb5, 0x2f, 0xfd);
  return isRar || is7z || isBzip2 || isXz || isZstd ? "other" : null;
}

/** Lists the files of an archive. Their names and paths are not read, so none can lead anywhere. */
export async function* filesIn(
  archive: Blob,
  format: ArchiveFormat,
  budget: Budget,
): AsyncGenerator<Piece | ArchiveFault> {
  if (format === "other") yield "format";
  if (format === "gzip") yield await gunzipped(archive, budget);
  const entries = format === "zip" ? zipEntries(archive) : format === "tar" ? tarEntries(archive) : [];
  for await (const entry of entries) {
    if (!budget.takeFile()) {
      yield "large";
      return;
    }
    yield entry;
  }
}

async function* zipEntries(archive: Blob): AsyncGenerator<Piece | ArchiveFault> {
  const stored = 0;
  const deflated = 8;
  const reader = new ZipReader(readerOf(archive), { strictness: "tolerant" });
  try {
    for await (const entry of reader.getEntriesGenerator()) {
      const { offset, compressedSize, compressionMethod, uncompressedSize, crc32 } = entry;
      if (entry.directory) continue;
      if (entry.encrypted) yield "encrypted";
      else if (compressionMethod !== stored && compressionMethod !== deflated) yield "format";
      else
        yield {
          size: uncompressedSize,
          blob: archive.slice(offset, offset + longestLocalHeader + compressedSize),
          zipped: {
            isDeflated: compressionMethod === deflated,
            packedSize: compressedSize,
            crc32: crc32 ?? 0,
          },
        };
    }
  } catch {
    yield "damaged";
  }
  await reader.close();
}

/** Adapts a Blob to the library, whose listing part has no reader for it. */
function readerOf(archive: Blob): Reader<Blob> {
  const readUint8Array = async (at: number, length: number) =>
    new Uint8Array(await archive.slice(at, at + length).arrayBuffer());
  return { size: archive.size, readUint8Array } as unknown as Reader<Blob>;
}

async function gunzipped(archive: Blob, budget: Budget): Promise<Piece | ArchiveFault> {
  let length = 0;
  const file = await collected(
    archive.stream().pipeThrough(new DecompressionStream("gzip")),
    budget.bytesLeft,
    (bytes) => (length += bytes.length),
  );
  if (length > budget.bytesLeft) return "large";
  if (!file) return "damaged";
  budget.takeBytes(file.size);
  return pieceOf(file);
}

const block = 512;

/**
 * Lists the files of a tar archive: headers, each followed by its file. Implemented here, because a
 * library would copy each file, while these are ranges of the archive. Names are skipped, so only
 * extended headers with a size matter.
 */
async function* tarEntries(archive: Blob): AsyncGenerator<Piece | ArchiveFault> {
  let longSize: number | null = null; // from an extended header, for the file after it
  for (let at = 0; at < archive.size;) {
    const header = new Uint8Array(await archive.slice(at, at + block).arrayBuffer());
    if (header.every((byte) => byte === 0)) return; // marks the end of the archive
    const kind = String.fromCharCode(header[156] ?? 0);
    const size: number | null = (isFile(kind) ? longSize : null) ?? numberAt(header, 124, 12);
    const from = at + block;
    if (!isHeader(header) || size === null || from + size > archive.size) {
      yield "damaged";
      return;
    }
    if (isFile(kind)) {
      longSize = null;
      if (size > 0) yield pieceOf(archive.slice(from, from + size));
    } else if (kind === "x") {
      longSize = sizeIn(await archive.slice(from, from + Math.min(size, longestExtendedHeader)).text());
    }
    at = from + Math.ceil(size / block) * block;
  }
}

const longestExtendedHeader = 1024 * 1024;
const isFile = (kind: string) => kind === "0" || kind === "\0" || kind === "7";
/** Returns the size in a POSIX pax header, where it has the form "21 size=8589934592". */
const sizeIn = (text: string): number | null => {
  const found = /(?:^|\n)\d+ size=(\d+)\n/.exec(text)?.[1];
  return found === undefined ? null : Number(found);
};

/** Parses a number in octal digits, or in binary if its first bit is set (GNU tar). */
function numberAt(header: Uint8Array, at: number, length: number): number | null {
  const bytes = header.subarray(at, at + length);
  if ((bytes[0] ?? 0) & 0x80) {
    const value = bytes.subarray(1).reduce((sum, byte) => sum * 256 + byte, (bytes[0] ?? 0) & 0x7f);
    return Number.isSafeInteger(value) ? value : null;
  }
  const digits = String.fromCharCode(...bytes)
    .replace(/[\0 ]+$/, "")
    .trimStart();
  return /^[0-7]*$/.test(digits) ? Number.parseInt(digits || "0", 8) : null;
}

function isHeader(header: Uint8Array): boolean {
  if (header.length < block) return false;
  const sum = header.reduce((total, byte, i) => total + (i >= 148 && i < 156 ? 32 : byte), 0);
  return numberAt(header, 148, 8) === sum;
}
