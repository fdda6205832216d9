import { fingerprintOf } from "../fingerprint";
import { collected, wholeOf, type Piece } from "../piece";
import type { Series, Thumbnail, Unsuitable } from "../types";
import { planOf } from "../upload_plan";
import { canonicalHeader } from "./canonical";
import { volumeBytes, voxelBytes, type ImageHeader, type VoxelType } from "./header";
import { drawImageThumbnail } from "./image_thumbnail";
import { judgeImage } from "./judge_image";

/** A file in a research format that was found, and its header. */
export interface FoundImage {
  readonly file: number;
  readonly header: ImageHeader;
}

/** A file to upload, and where its voxels begin. */
interface Voxels {
  readonly file: number;
  readonly blob: Blob;
  readonly from: number;
  /** Whether `blob` replaces the file, because its voxels were compressed. */
  readonly isUnpacked: boolean;
}

const missing: Unsuitable = { suitable: false, reason: "no_voxels", count: 0 };
const damaged: Unsuitable = { suitable: false, reason: "damaged", count: 0 };

/**
 * Returns the series of a research file, and the index of the file with its voxels if they are in a
 * second one.
 */
export async function imageSeries(
  { file, header }: FoundImage,
  pieces: readonly Piece[],
): Promise<{ readonly series: Series; readonly second: number | null }> {
  const verdict = judgeImage(header);
  const series = (rest: Partial<Series>): Series => ({ ...blank(file, header, pieces), verdict, ...rest });
  const { type } = header;
  if (!verdict.suitable || type === null) return { series: series({}), second: null };
  const second = header.begin === null ? fileOfVoxels(header, pieces) : null;
  if (header.begin === null && second === null) return { series: series({ verdict: missing }), second };
  const voxels = await volumesOf(header, second ?? file, pieces).catch(() => null);
  if (!voxels) return { series: series({ verdict: damaged }), second };
  const full = { ...header, type };
  const head = canonicalHeader(full);
  const to = voxels.from + voxelBytes(header);
  const bytes = volumeBytes(header);
  const upload = planOf(
    Array.from({ length: header.volumes }, (_, i) => ({
      file: voxels.file,
      head: i === 0 ? head : new Uint8Array(),
      from: voxels.from + i * bytes,
      to: voxels.from + (i + 1) * bytes,
      inflated: voxels.isUnpacked ? voxels.blob : null,
    })),
    true,
  );
  const content = voxels.blob.slice(voxels.from, to);
  return {
    series: series({
      upload,
      thumbnail: await thumbnailOf(full, content),
      fingerprint: fingerprintOf(await identifying(head, content)),
    }),
    second,
  };
}

const nothing: Series["upload"] = planOf([]);

function blank(file: number, header: ImageHeader, pieces: readonly Piece[]): Omit<Series, "verdict"> {
  const blob = pieces[file]?.blob;
  return {
    key: `image ${file}`,
    description: "",
    fileName: blob instanceof File ? blob.name : "",
    bodyPart: "",
    date: "",
    modality: header.modality,
    seriesNumber: null,
    patient: { name: "", id: "", birthDate: "" },
    slices: header.size[2],
    thumbnail: null,
    upload: nothing,
    fingerprint: "",
  };
}

/**
 * Returns the only file whose length is that of the voxels. Its name cannot be used, because files
 * in archives have none here.
 */
function fileOfVoxels(header: ImageHeader, pieces: readonly Piece[]): number | null {
  const length = header.storedBytes ?? (header.coding === "raw" ? voxelBytes(header) : null);
  const fitting = pieces.flatMap(({ size }, i) => (size === length ? [i] : []));
  return fitting.length === 1 ? (fitting[0] ?? null) : null;
}

/** Returns the voxels volume by volume, or null if they are damaged. */
async function volumesOf(header: ImageHeader, file: number, pieces: readonly Piece[]): Promise<Voxels | null> {
  const voxels = await voxelsOf(header, file, pieces);
  if (!voxels || header.run === voxelBytes({ ...header, volumes: 1, type: "int8" })) return voxels;
  const { blob, from } = voxels;
  return { file, blob: await byVolume(header, blob.slice(from, from + voxelBytes(header))), from: 0, isUnpacked: true };
}

/** Size of what is sorted at once. */
const sortedBytes = 1 << 24;

/** Sorts voxels, of which short runs of each volume alternate, by volume. */
async function byVolume(header: ImageHeader, blob: Blob): Promise<Blob> {
  const { volumes } = header;
  const run = (header.run * volumeBytes(header)) / (header.size[0] * header.size[1] * header.size[2]);
  const turn = run * volumes;
  const parts = Array.from({ length: volumes }, (): Blob[] => []);
  const step = Math.max(1, Math.floor(sortedBytes / turn)) * turn;
  for (let at = 0; at < blob.size; at += step) {
    const mixed = new Uint8Array(await blob.slice(at, at + step).arrayBuffer());
    const turns = mixed.length / turn;
    parts.forEach((part, volume) => {
      const sorted = new Uint8Array(turns * run);
      for (let i = 0, to = 0; i < turns; i++)
        for (let byte = 0, from = i * turn + volume * run; byte < run; byte++) sorted[to++] = mixed[from++] ?? 0;
      part.push(new Blob([sorted]));
    });
  }
  return new Blob(parts.flat());
}

async function voxelsOf(header: ImageHeader, file: number, pieces: readonly Piece[]): Promise<Voxels | null> {
  const piece = pieces[file];
  if (!piece) return null;
  const whole = await wholeOf(piece);
  const bytes = voxelBytes(header);
  const from = header.begin ?? 0;
  if (header.coding === "raw") {
    return whole.size >= from + bytes ? { file, blob: whole, from, isUnpacked: false } : null;
  }
  const packed = whole.slice(from).stream();
  const blob = await collected(
    packed.pipeThrough(new DecompressionStream(header.coding === "gzip" ? "gzip" : "deflate")),
    bytes,
  );
  return blob?.size === bytes ? { file, blob, from: 0, isUnpacked: true } : null;
}

async function thumbnailOf(
  image: ImageHeader & { readonly type: VoxelType },
  content: Blob,
): Promise<Thumbnail | null> {
  const [, , z] = image.size;
  const slice = volumeBytes(image) / z;
  const middle = Math.floor(z / 2) * slice;
  try {
    return drawImageThumbnail(image, await content.slice(middle, middle + slice).arrayBuffer());
  } catch {
    return null; // a series without a thumbnail is still shown
  }
}

/** Returns bytes that distinguish files: the header, the length, and three parts of the voxels. */
async function identifying(head: Uint8Array, content: Blob): Promise<Iterable<number>> {
  const part = 64 * 1024;
  const parts = [0, content.size / 2, content.size - part].map((at) => Math.max(0, Math.floor(at)));
  const read = await Promise.all(parts.map((at) => content.slice(at, at + part).arrayBuffer()));
  return [head, ...read.map((one) => new Uint8Array(one))].flatMap((bytes) => [...bytes]);
}
