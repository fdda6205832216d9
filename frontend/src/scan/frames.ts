import type { DataSet } from "dicom-parser";
import { grouped_element, grouped_tags } from "./clean_file";
import type { GroupedElement, SliceHeader } from "./types";

/** The functional groups of an enhanced file (DICOM PS3.3, C.7.6.16): where each of its pictures lies. */

const shared_groups = "x52009229";
const frame_groups = "x52009230";
const enhanced = new Set(["2.1", "2.2", "4.1", "4.4", "128.1", "130"].map((leaf) => `1.2.840.10008.5.1.4.1.1.${leaf}`));
const most_frames = 20_000;

/** One header a picture; of a file that is none of these, or does not say where its pictures lie, the one it has. */
export function frames_of(data: DataSet, header: SliceHeader): readonly SliceHeader[] {
  const each = data.elements[frame_groups]?.items;
  const shared = data.elements[shared_groups]?.items?.[0]?.dataSet;
  if (!enhanced.has(header.sop_class) || (!each && !shared) || header.frames > most_frames) return [header];
  if (each && each.length !== header.frames) return [{ ...header, truncated: true }];
  const common = shared ? grouped_of(shared) : [];
  return Array.from({ length: header.frames }, (_, frame) => {
    const own = each?.[frame]?.dataSet;
    return with_groups({ ...header, frame, frames: 1 }, [...common, ...(own ? grouped_of(own) : [])]);
  });
}

function grouped_of(item: DataSet): GroupedElement[] {
  return Object.entries(grouped_tags).flatMap(([group, tags]) => {
    const inner = item.elements[group]?.items?.[0]?.dataSet;
    if (!inner) return [];
    return tags.flatMap((tag) => {
      const found = inner.elements[tag];
      const bytes = found && bytes_of(inner).subarray(found.dataOffset, found.dataOffset + found.length);
      return (bytes && grouped_element(group, tag, bytes)) ?? [];
    });
  });
}

/** What the groups say comes after what stands at the top of the file. */
function with_groups(header: SliceHeader, grouped: readonly GroupedElement[]): SliceHeader {
  const text = (tag: string): string | null => {
    const found = grouped.findLast((one) => one.tag === tag);
    return found ? String.fromCharCode(...found.bytes).replace(/[\0 ]+$/, "") : null;
  };
  const numbers = (tag: string, count: number): number[] | null => {
    const values = (text(tag) ?? "").split("\\").map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
    return values.length === count && values.every(Number.isFinite) ? values : null;
  };
  const one = (tag: string): number | null => numbers(tag, 1)?.[0] ?? null;
  const center = one("x00281050");
  const width = one("x00281051");
  return {
    ...header,
    grouped,
    stack: text("x00209056") ?? "1",
    image_type: text("x00089007")?.split("\\").map((part) => part.trim()) ?? header.image_type,
    position: (numbers("x00200032", 3) as SliceHeader["position"]) ?? header.position,
    orientation: (numbers("x00200037", 6) as SliceHeader["orientation"]) ?? header.orientation,
    pixel_spacing: (numbers("x00280030", 2) as SliceHeader["pixel_spacing"]) ?? header.pixel_spacing,
    has_scale: header.has_scale || one("x00281053") !== null,
    slope: one("x00281053") ?? header.slope,
    intercept: one("x00281052") ?? header.intercept,
    window: center !== null && width !== null && width > 0 ? { center, width } : header.window,
    pixels: pixels_of(header),
  };
}

function pixels_of({ pixels, frame, rows, columns, bits_allocated, samples }: SliceHeader): SliceHeader["pixels"] {
  const length = (rows * columns * samples * bits_allocated) / 8;
  return pixels ? { offset: pixels.offset + frame * length, length } : null;
}

/** Typed with Node's Buffer, which a browser has not. */
// eslint-disable-next-line @typescript-eslint/no-unsafe-return
export const bytes_of = (data: DataSet): Uint8Array => data.byteArray;
