import { withTemporalPosition } from "./clean_file";
import { hasPhases, placesOf, splitPhases, thinned } from "./phases";
import { arrange, cross, type Axes, type Vector } from "./stack";
import type { Chosen, LeftOut, Phases, Reason, Repair, SliceHeader, Unsuitable } from "./types";

/**
 * Decides whether the files of one series can become a volume, by the same cases as ingest (ingest/dicom/classify.cpp).
 * Never relies on SliceThickness, SpacingBetweenSlices or InstanceNumber. It is a preview for the user, and the server
 * decides again.
 */

export const fewestSlices = 16;
export const shortestMm = 20;
/** The server's limits per file, as sent and as decompressed (ingest/dicom/precheck.h), and per scan (scan.h). */
export const mostFileBytes = 2 ** 30;
export const mostVoxels = 2 ** 30;
export const mostSlices = 20_000;
export const mostPhases = 1000;

const imageRoot = "1.2.840.10008.5.1.4.1.1.";
const slicesOf = new Set(["2", "4", "128", "2.1", "2.2", "4.1", "4.4", "128.1", "130"].map((leaf) => imageRoot + leaf));

/**
 * Whether a file is a slice of a CT, MR or PET scan. Other files are reports, screenshots, plans or structures and are
 * never listed.
 */
export const isSlice = ({ sopClass, voxels, truncated }: SliceHeader): boolean =>
  slicesOf.has(sopClass) && (voxels !== null || truncated);

const transferSyntaxes = new Set([
  "1.2.840.10008.1.2",
  "1.2.840.10008.1.2.1",
  "1.2.840.10008.1.2.1.99",
  "1.2.840.10008.1.2.2",
  "1.2.840.10008.1.2.5",
  "1.2.840.10008.1.2.4.50",
  "1.2.840.10008.1.2.4.51",
  "1.2.840.10008.1.2.4.57",
  "1.2.840.10008.1.2.4.70",
  "1.2.840.10008.1.2.4.80",
  "1.2.840.10008.1.2.4.81",
  "1.2.840.10008.1.2.4.90",
  "1.2.840.10008.1.2.4.91",
]);

const refuse = (reason: Reason, count = 0): Unsuitable => ({ suitable: false, reason, count });

export function judge(all: readonly SliceHeader[]): Chosen | Unsuitable {
  const ofClass = all.filter(isSlice);
  if (ofClass.length === 0) return refuse("no_slices", all.length);
  const complete = ofClass.filter((slice) => !slice.truncated);
  // A file that ends within its header does not state its encoding, so the others decide.
  const coded = ofClass.filter((slice) => slice.transferSyntax !== "");
  if (coded.some((slice) => !transferSyntaxes.has(slice.transferSyntax)))
    return refuse("unsupported_compression", ofClass.length);
  if (complete.length === 0) return refuse("damaged", ofClass.length);
  if (complete.some((slice) => slice.modality !== complete[0]?.modality)) return refuse("mixed", complete.length);
  if (complete.some(isView)) return refuse("views_not_slices", complete.length);
  if (!complete.every(isOriginal)) return refuse("not_original");

  const single = withoutDoubles(complete);
  if (!single) return refuse("repeated_identifier");
  const kept = single.filter((slice) => !slice.imageType.includes("LOCALIZER"));
  if (kept.length === 0) return refuse("scout", single.length);
  if (kept.some((slice) => slice.frames > 1)) return refuse("no_position", kept.length);
  if (kept.some((s) => s.samples !== 1 || !/^MONOCHROME[12]$/.test(s.photometric)))
    return refuse("screenshots", kept.length);
  return judgeGeometry(kept, {
    scouts: single.length - kept.length,
    doubles: complete.length - single.length,
    damaged: ofClass.length - complete.length,
    others: 0,
  });
}

const viewMarks = ["PROJECTION", "MIP", "MINIP", "ROTAT", "VRT"];
const isView = (slice: SliceHeader) => slice.imageType.some((part) => viewMarks.some((mark) => part.includes(mark)));

/** Whether a slice is an original. Files of type "MIXED" are decided frame by frame. */
function isOriginal({ imageType: [first = "", second], isLossy }: SliceHeader): boolean {
  return (
    first === "" ||
    first === "ORIGINAL" ||
    first === "MIXED" ||
    (first === "DERIVED" && isLossy && second === "PRIMARY")
  );
}

/**
 * Removes objects that occur twice on the disc (case 7). Returns null if one identifier belongs to
 * two positions.
 */
function withoutDoubles(slices: readonly SliceHeader[]): SliceHeader[] | null {
  const seen = new Map<string, SliceHeader>();
  const kept: SliceHeader[] = [];
  for (const slice of slices) {
    const key = `${slice.sopUid} ${slice.frame}`;
    const before = slice.sopUid ? seen.get(key) : undefined;
    if (before && String(before.position) !== String(slice.position)) return null;
    if (before) continue;
    seen.set(key, slice);
    kept.push(slice);
  }
  return kept;
}

function judgeGeometry(slices: readonly SliceHeader[], leftOut: LeftOut): Chosen | Unsuitable {
  if (slices.some((s) => !s.position || !s.orientation)) return refuse("no_position", slices.length);
  if (
    slices.some((s) => !s.pixelSpacing || !s.pixelSpacing.every(isPlausibleSpacing) || s.rows === 0 || s.columns === 0)
  )
    return refuse("no_spacing", slices.length);
  if (slices.some((s) => !axesOf(s.orientation))) return refuse("bad_orientation", slices.length);
  const turned = groupsOf(slices, (a, b) => near(a.orientation, b.orientation, 4e-3));
  const main = largest(turned);
  const strangers = slices.length - main.length;
  if (turned.length > 3 && 2 * strangers > slices.length) return refuse("views_not_slices", slices.length);
  if (strangers > mostStrangers && main.length >= fewestSlices) return refuse("mixed", slices.length);

  const even = largest(groupsOf(main, sameSize));
  const others = main.length - even.length;
  if (even.length < fewestSlices) return refuse(main.length >= fewestSlices ? "mixed" : "too_few_slices", even.length);
  const unscaled = judgeScale(even);
  if (unscaled) return unscaled;
  return judgeStack(even, { ...leftOut, scouts: leftOut.scouts + strangers, others });
}

/** Whether a pixel spacing in mm is plausible. Those of scanners lie far within these bounds. */
const isPlausibleSpacing = (mm: number): boolean => mm >= 1e-3 && mm <= 100;

/**
 * Maximum number of images in another direction that are unmarked overview images. More are a
 * separate series.
 */
const mostStrangers = 3;

/**
 * Whether the scale of a slice is plausible. Those of real scans lie far within these limits, which
 * are the same in ingest/dicom/classify.cpp.
 */
function isPlausibleScale(slice: SliceHeader): boolean {
  const size = Math.abs(slice.slope);
  if (!Number.isFinite(size) || !Number.isFinite(slice.intercept) || size < 1e-12) return false;
  return slice.modality === "CT" ? size <= 1000 && Math.abs(slice.intercept) <= 1e5 : size <= 1e12;
}

function judgeScale(slices: readonly SliceHeader[]): Unsuitable | null {
  if (slices.some((slice) => slice.hasLookupTable)) return refuse("lookup_table");
  if (slices.some((slice) => slice.photometric !== slices[0]?.photometric)) return refuse("mixed", slices.length);
  if (slices.some((slice) => !isPlausibleScale(slice))) return refuse("bad_rescale");
  const unknown = (slice: SliceHeader) => slice.modality === "CT" && !slice.hasScale && !slice.isSigned;
  if (slices.some(unknown)) return refuse("no_rescale");
  if (slices.some((slice) => ![8, 16].includes(slice.bitsAllocated))) return refuse("pixel_format");
  return null;
}

/** The slices of each phase, of which the first one is arranged and the others lie in the same places. */
interface Split {
  readonly phases: readonly (readonly SliceHeader[])[];
  readonly described: Omit<Phases, "count"> | null;
  readonly repairs: readonly Repair[];
}

/** Splits a series that repeats its positions into phases. */
function split(slices: readonly SliceHeader[], axes: Axes, pixel: number): Split | Unsuitable {
  const places = placesOf(slices, axes);
  if (!hasPhases(places, slices.length)) return { phases: [slices], described: null, repairs: [] };
  const found = splitPhases(places, pixel);
  if ("reason" in found) return refuse(found.reason);
  const { incomplete, uncommon } = found;
  // The server cannot tell phases by what is not sent, such as a time of day, so their order is sent instead.
  const isOrderOnly = found.kind === "index" && found.by !== "instance";
  return {
    phases: isOrderOnly
      ? found.phases.map((phase, i) => phase.map((slice) => withTemporalPosition(slice, i + 1)))
      : found.phases,
    described: { kind: found.kind, range: found.range },
    repairs: [
      ...(incomplete > 0 ? [{ kind: "incomplete_phases", phases: incomplete } as const] : []),
      ...(uncommon > 0 ? [{ kind: "uncommon", slices: uncommon } as const] : []),
    ],
  };
}

function judgeStack(all: readonly SliceHeader[], leftOut: LeftOut): Chosen | Unsuitable {
  const axes = axesOf(all[0]?.orientation ?? null);
  const parts = axes && split(all, axes, Math.min(...(all[0]?.pixelSpacing ?? [1])));
  if (!parts) return refuse("no_position", all.length);
  if ("suitable" in parts) return parts;
  const slices = parts.phases[0] ?? [];
  const first = slices[0];
  if (slices.length < fewestSlices) return refuse("too_few_slices", slices.length);
  const positions = slices.flatMap(({ position }) => (position ? [position] : []));
  if (!first?.pixelSpacing) return refuse("no_position", slices.length);
  const found = arrange(positions, axes, Math.min(...first.pixelSpacing));
  if (!found.volume)
    return refuse(found.reason === "one_position" && first.stack !== "" ? "cine" : found.reason, found.count);
  const height = found.slices * found.spacing;
  if (height < shortestMm) return refuse("too_short", Math.round(height));
  const voxels = first.rows * first.columns * found.slices;
  const most = Math.min(mostPhases, Math.floor(mostVoxels / voxels), Math.floor(mostSlices / slices.length));
  const phases = thinned(parts.phases, most);
  if (most === 0 || isTooLarge(phases.flat())) return refuse("too_large");
  const fewer: Repair = { kind: "fewer_phases", kept: phases.length, of: parts.phases.length };
  return {
    suitable: true,
    phases: parts.described && phases.length > 1 ? { ...parts.described, count: phases.length } : null,
    slices: phases.flatMap((phase) => found.order.flatMap((i) => phase[i] ?? [])),
    size: [first.columns, first.rows, found.slices],
    sizeMm: [first.columns * first.pixelSpacing[1], first.rows * first.pixelSpacing[0], height],
    leftOut,
    repairs: [...parts.repairs, ...(phases.length < parts.phases.length ? [fewer] : []), ...found.repairs],
  };
}

/**
 * Whether a series exceeds the server's limits. A file is sent as a whole, even if only some of its
 * frames are chosen.
 */
function isTooLarge(slices: readonly SliceHeader[]): boolean {
  if (slices.length > mostSlices) return true;
  const unpacked = new Map<number, number>();
  for (const { file, rows, columns, bitsAllocated } of slices)
    unpacked.set(file, (unpacked.get(file) ?? 0) + (rows * columns * bitsAllocated) / 8);
  const sent = ({ voxels }: SliceHeader) => (voxels ? voxels.to - voxels.from : 0);
  return slices.some((slice) => Math.max(sent(slice), unpacked.get(slice.file) ?? 0) > mostFileBytes);
}

/** Returns the axes of a slice, or null if its two directions are not orthonormal. */
function axesOf(orientation: SliceHeader["orientation"]): Axes | null {
  if (!orientation) return null;
  const [a, b, c, d, e, f] = orientation;
  const row: Vector = [a, b, c];
  const column: Vector = [d, e, f];
  const off = Math.max(
    Math.abs(Math.hypot(...row) - 1),
    Math.abs(Math.hypot(...column) - 1),
    Math.abs(a * d + b * e + c * f),
  );
  return off > 0.01 ? null : { row, column, normal: cross(row, column) };
}

function groupsOf(slices: readonly SliceHeader[], same: (a: SliceHeader, b: SliceHeader) => boolean): SliceHeader[][] {
  const groups: SliceHeader[][] = [];
  for (const slice of slices) {
    const group = groups.find(([first]) => first && same(slice, first));
    if (group) group.push(slice);
    else groups.push([slice]);
  }
  return groups;
}

const largest = (groups: readonly SliceHeader[][]): SliceHeader[] =>
  groups.reduce((a, b) => (b.length > a.length ? b : a), []);

const near = (a: readonly number[] | null, b: readonly number[] | null, tolerance: number): boolean =>
  a?.every((value, i) => Math.abs(value - (b?.[i] ?? Number.NaN)) <= tolerance) ?? false;

const sameSize = (slice: SliceHeader, first: SliceHeader): boolean =>
  slice.rows === first.rows && slice.columns === first.columns && near(slice.pixelSpacing, first.pixelSpacing, 1e-3);
