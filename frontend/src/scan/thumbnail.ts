import type { SliceHeader, Thumbnail } from "./types";

const side = 160;

/**
 * Draws a thumbnail of one slice under its window. Returns null for compressed files, for which the server creates one
 * later.
 */
export function drawThumbnail(slice: SliceHeader, pixels: ArrayBuffer): Thumbnail | null {
  const read = reader(slice, pixels);
  if (!read || slice.rows === 0 || slice.columns === 0 || !slice.pixelSpacing) return null;
  const wide = slice.columns * slice.pixelSpacing[1];
  const tall = slice.rows * slice.pixelSpacing[0];
  const { columns, rows } = slice;
  const size = { columns, rows, wide: wide / columns, tall: tall / rows };
  const scaled = (column: number, row: number) => read(row * columns + column) * slice.slope + slice.intercept;
  const drawn = draw(size, scaled, slice.window);
  return slice.photometric === "MONOCHROME1" && !hasUnits(slice)
    ? { ...drawn, gray: drawn.gray.map((level) => 255 - level) }
    : drawn;
}

/**
 * Whether the values mean the same however the file wants them displayed, so that the server keeps them as well
 * (ingest/dicom/classify.cpp): Hounsfield units, and the activity of a PET scan. Other values of MONOCHROME1 are those
 * of a negative.
 */
const hasUnits = ({ modality }: SliceHeader): boolean => modality === "CT" || modality === "PT";

/** The pixels of a slice, and the size of one in mm, because it need not be square. */
interface PixelGrid {
  readonly columns: number;
  readonly rows: number;
  readonly wide: number;
  readonly tall: number;
}

/** Draws a slice under a window, or by default under one from the 2nd to the 98th percentile. */
export function draw(
  { columns, rows, ...pixel }: PixelGrid,
  valueAt: (column: number, row: number) => number,
  window: SliceHeader["window"] = null,
): Thumbnail {
  const shrink = side / Math.max(columns * pixel.wide, rows * pixel.tall);
  const width = Math.max(1, Math.round(columns * pixel.wide * shrink));
  const height = Math.max(1, Math.round(rows * pixel.tall * shrink));
  const values = new Float32Array(width * height);
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      const row = Math.floor(((y + 0.5) / height) * rows);
      const column = Math.floor(((x + 0.5) / width) * columns);
      values[y * width + x] = valueAt(column, row);
    }
  const { center, width: range } = window ?? spreadOf(values);
  const gray = Uint8Array.from(values, (value) => Math.min(255, Math.max(0, ((value - center) / range + 0.5) * 255)));
  return { width, height, gray };
}

function reader(slice: SliceHeader, pixels: ArrayBuffer): ((index: number) => number) | null {
  const count = slice.rows * slice.columns;
  if (slice.bitsAllocated === 8 && pixels.byteLength >= count) {
    const bytes = new Uint8Array(pixels);
    return (i) => bytes[i] ?? 0;
  }
  if (slice.bitsAllocated !== 16 || pixels.byteLength < 2 * count) return null;
  const view = new DataView(pixels);
  const unused = 32 - Math.min(16, Math.max(1, slice.bitsStored));
  return slice.isSigned
    ? (i) => (view.getUint16(2 * i, true) << unused) >> unused // case 17: the bits above the stored ones mean nothing
    : (i) => (view.getUint16(2 * i, true) << unused) >>> unused;
}

function spreadOf(values: Float32Array): { center: number; width: number } {
  const sorted = Float32Array.from(values).sort();
  const at = (part: number) => sorted[Math.floor(part * (sorted.length - 1))] ?? 0;
  const range = at(0.98) - at(0.02);
  return { center: (at(0.02) + at(0.98)) / 2, width: range > 0 ? range : 1 };
}
