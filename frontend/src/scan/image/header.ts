/**
 * Research formats: what NIfTI, NRRD and MetaImage files say about their voxels. Everything else in
 * their headers stays in the browser.
 */

export type VoxelType = "int8" | "uint8" | "int16" | "uint16" | "int32" | "uint32" | "float32" | "float64";

export const bytesOf: Readonly<Record<VoxelType, number>> = {
  int8: 1,
  uint8: 1,
  int16: 2,
  uint16: 2,
  int32: 4,
  uint32: 4,
  float32: 4,
  float64: 8,
};

export type Triple = readonly [number, number, number];

export interface ImageHeader {
  readonly size: Triple;
  /** Number of volumes, such as the moments of a time series. */
  readonly volumes: number;
  /**
   * Number of voxels that lie together before the next volume's: those of a whole volume, or fewer
   * if the axis of the volumes is not the last one.
   */
  readonly run: number;
  /** Time from volume to volume in ms. Null if the file does not say. */
  readonly stepMs: number | null;
  /** Number of values per voxel, such as the three of a colour. */
  readonly values: number;
  /** The type of the values, or null for an unsupported one. */
  readonly type: VoxelType | null;
  readonly littleEndian: boolean;
  /** The step from voxel to voxel along each axis, in mm in the patient's space (LPS). Null if the file does not say. */
  readonly axes: readonly [Triple, Triple, Triple] | null;
  /** Centre of the first voxel in mm in the patient's space (LPS). Null if the file does not say. */
  readonly origin: Triple | null;
  /** Distances between voxel centres along each axis in mm. Used only if `axes` is null. */
  readonly spacing: Triple;
  readonly slope: number;
  readonly intercept: number;
  /** "CT", "MR", "PT" or empty. */
  readonly modality: string;
  readonly coding: "raw" | "gzip" | "zlib" | "other";
  /** Position of the voxels in the file. Null if they are in another file, at its beginning. */
  readonly begin: number | null;
  /** Length of the voxels as stored, if the header says so. */
  readonly storedBytes: number | null;
}

/** Bytes of the voxels of all volumes, unpacked. */
export const voxelBytes = ({ size: [x, y, z], volumes, type }: ImageHeader): number =>
  x * y * z * volumes * (type ? bytesOf[type] : 1);

/** Bytes of the voxels of one volume, unpacked. */
export const volumeBytes = (image: ImageHeader): number => voxelBytes(image) / image.volumes;

/** Returns the time from volume to volume if it is one, else null. */
export const stepOrNull = (ms: number): number | null => (ms > 0 && Number.isFinite(ms) ? ms : null);

export const fromRas = ([x, y, z]: Triple): Triple => [-x, -y, z];

/** Returns a position, or null if one of its numbers is missing or not finite. */
export const placeOrNull = (place: Triple): Triple | null => (place.every(Number.isFinite) ? place : null);

export const triple = (numbers: readonly number[], at = 0): Triple => [
  numbers[at] ?? Number.NaN,
  numbers[at + 1] ?? Number.NaN,
  numbers[at + 2] ?? Number.NaN,
];

export const times = ([x, y, z]: Triple, by: number): Triple => [x * by, y * by, z * by];

export const lengths = ([x, y, z]: readonly [Triple, Triple, Triple]): Triple => [
  Math.hypot(...x),
  Math.hypot(...y),
  Math.hypot(...z),
];

/**
 * The result of reading a header: "more" if it continues beyond `bytes`, null for another format.
 */
export type ImageRead = ImageHeader | "more" | null;

/**
 * Returns the text before the match of `end` and the offset after it. Null if `bytes` contains no
 * match.
 */
export function textBefore(bytes: Uint8Array, end: RegExp): { readonly text: string; readonly after: number } | null {
  // Latin-1, so that each character is one byte.
  const text = new TextDecoder("latin1").decode(bytes);
  const found = end.exec(text);
  return found ? { text: text.slice(0, found.index), after: found.index + found[0].length } : null;
}

/** Parses the numbers of a text, separated by blanks, commas or parentheses. */
export const numbersIn = (text: string): number[] =>
  text
    .split(/[\s,()]+/)
    .filter((word) => word !== "")
    .map(Number);
