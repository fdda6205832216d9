import type { DataSet } from "dicom-parser";
import { bigEndian, groupedElement, groupedTags } from "./clean_file";
import type { GroupedElement, SliceHeader } from "./types";

/** Reads the functional groups of an enhanced file (DICOM PS3.3, C.7.6.16), which give the position of each frame. */

const sharedGroups = "x52009229";
const frameGroups = "x52009230";
const enhanced = new Set(["2.1", "2.2", "4.1", "4.4", "128.1", "130"].map((leaf) => `1.2.840.10008.5.1.4.1.1.${leaf}`));
const mostFrames = 20_000;

/**
 * Returns one header per frame. A file of another kind, or without positions of its frames, keeps its single header.
 */
export function framesOf(data: DataSet, header: SliceHeader): readonly SliceHeader[] {
  const each = data.elements[frameGroups]?.items;
  const shared = data.elements[sharedGroups]?.items?.[0]?.dataSet;
  if (!enhanced.has(header.sopClass) || (!each && !shared) || header.frames > mostFrames) return [header];
  if (each && each.length !== header.frames) return [{ ...header, truncated: true }];
  const common = shared ? groupedOf(shared) : [];
  return Array.from({ length: header.frames }, (_, frame) => {
    const own = each?.[frame]?.dataSet;
    return withGroups({ ...header, frame, frames: 1 }, [...common, ...(own ? groupedOf(own) : [])]);
  });
}

function groupedOf(item: DataSet): GroupedElement[] {
  return Object.entries(groupedTags).flatMap(([group, tags]) => {
    const inner = item.elements[group]?.items?.[0]?.dataSet;
    if (!inner) return [];
    return tags.flatMap((tag) => {
      const found = inner.elements[tag];
      const bytes = found && bytesOf(inner).subarray(found.dataOffset, found.dataOffset + found.length);
      return (bytes && groupedElement(group, tag, bytes)) ?? [];
    });
  });
}

/** Returns the header of a frame. Values in the groups override those at the top of the file. */
function withGroups(header: SliceHeader, grouped: readonly GroupedElement[]): SliceHeader {
  const text = (tag: string): string | null => {
    const found = grouped.findLast((one) => one.tag === tag);
    return found ? String.fromCharCode(...found.bytes).replace(/[\0 ]+$/, "") : null;
  };
  const numbers = (tag: string, count: number): number[] | null => {
    const values = (text(tag) ?? "").split("\\").map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
    return values.length === count && values.every(Number.isFinite) ? values : null;
  };
  const one = (tag: string): number | null => numbers(tag, 1)?.[0] ?? null;
  const binary = (tag: string): number | null => {
    const found = grouped.findLast((one) => one.tag === tag);
    if (!found) return null;
    const view = new DataView(found.bytes.buffer, found.bytes.byteOffset, found.bytes.byteLength);
    const little = header.transferSyntax !== bigEndian;
    const value =
      found.vr === "UL"
        ? view.getUint32(0, little)
        : found.vr === "FL"
          ? view.getFloat32(0, little)
          : view.getFloat64(0, little);
    return Number.isFinite(value) ? value : null;
  };
  const offset = binary("x0020930d");
  const ofFrame = [
    binary("x00189087"),
    binary("x00189082"),
    binary("x00209241"),
    binary("x00209153"),
    offset === null ? null : 1000 * offset,
    binary("x00209128"),
  ];
  const center = one("x00281050");
  const width = one("x00281051");
  return {
    ...header,
    grouped,
    moment: header.moment.map((value, i) => ofFrame[i] ?? value),
    stack: text("x00209056") ?? "1",
    imageType:
      text("x00089007")
        ?.split("\\")
        .map((part) => part.trim()) ?? header.imageType,
    position: (numbers("x00200032", 3) as SliceHeader["position"]) ?? header.position,
    orientation: (numbers("x00200037", 6) as SliceHeader["orientation"]) ?? header.orientation,
    pixelSpacing: (numbers("x00280030", 2) as SliceHeader["pixelSpacing"]) ?? header.pixelSpacing,
    hasScale: header.hasScale || one("x00281053") !== null,
    slope: one("x00281053") ?? header.slope,
    intercept: one("x00281052") ?? header.intercept,
    window: center !== null && width !== null && width > 0 ? { center, width } : header.window,
    pixels: pixelsOf(header),
  };
}

function pixelsOf({ pixels, frame, rows, columns, bitsAllocated, samples }: SliceHeader): SliceHeader["pixels"] {
  const length = (rows * columns * samples * bitsAllocated) / 8;
  return pixels ? { offset: pixels.offset + frame * length, length } : null;
}

/**
 * Returns the bytes of a data set. Their type is Node's Buffer, which does not exist in a browser.
 */
// eslint-disable-next-line @typescript-eslint/no-unsafe-return
export const bytesOf = (data: DataSet): Uint8Array => data.byteArray;
