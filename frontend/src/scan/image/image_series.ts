import { fingerprintOf } from "../fingerprint";
import { collected, wholeOf, type Piece } from "../piece";
import type { Series, Thumbnail, Unsuitable } from "../types";
import { planOf } from "../upload_plan";
import { canonicalHeader } from "./canonical";
import { voxelBytes, type ImageHeader, type VoxelType } from "./header";
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
  const voxels = await voxelsOf(header, second ?? file, pieces).catch(() => null);
  if (!voxels) return { series: series({ verdict: damaged }), second };
  const full = { ...header, type };
  const head = canonicalHeader(full);
  const to = voxels.from + voxelBytes(header);
  const upload = planOf([
    { file: voxels.file, head, from: voxels.from, to, inflated: voxels.isUnpacked ? voxels.blob : null },
  ]);
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
  const slice = voxelBytes(image) / image.volumes / z;
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
