import type { SliceHeader, Thumbnail } from "./types";

const side = 160;

/**
 * Draws a thumbnail of one slice under its window. Returns null for compressed files, for which the server creates one
 * later.
 */
export function drawThumbnail(slice: SliceHeader, pixels: ArrayBuffer): Thumbnail | null {
  const read = reader(slice, pixels);
  if (!read || slice.rows === 0 || slice.columns === 0 || !slice.pixelSpacing) return null;
  // The height in mm, because pixels need not be square.
  const tall = slice.rows * slice.pixelSpacing[0];
  const wide = slice.columns * slice.pixelSpacing[1];
  const shrink = side / Math.max(tall, wide);
  const width = Math.max(1, Math.round(wide * shrink));
  const height = Math.max(1, Math.round(tall * shrink));
  const values = new Float32Array(width * height);
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      const row = Math.floor(((y + 0.5) / height) * slice.rows);
      const column = Math.floor(((x + 0.5) / width) * slice.columns);
      values[y * width + x] = read(row * slice.columns + column) * slice.slope + slice.intercept;
    }
  const { center, width: range } = slice.window ?? spreadOf(values);
  const darkFirst = slice.photometric !== "MONOCHROME1";
  const gray = new Uint8Array(width * height);
  values.forEach((value, i) => {
    const level = Math.min(255, Math.max(0, ((value - center) / range + 0.5) * 255));
    gray[i] = darkFirst ? level : 255 - level;
  });
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

/** The window for a slice without one: from the 2nd to the 98th percentile. */
function spreadOf(values: Float32Array): { center: number; width: number } {
  const sorted = Float32Array.from(values).sort();
  const at = (part: number) => sorted[Math.floor(part * (sorted.length - 1))] ?? 0;
  return { center: (at(0.02) + at(0.98)) / 2, width: Math.max(1, at(0.98) - at(0.02)) };
}
