import { arrange, cross, type Axes, type Vector } from "./stack";
import type { Chosen, LeftOut, Reason, SliceHeader, Unsuitable } from "./types";

/**
 * Whether the files of one series can become a volume, by the cases of ingest (ingest/dicom/classify.cpp). Never trusts
 * SliceThickness, SpacingBetweenSlices or InstanceNumber. A preview for the person: the server judges again.
 */

export const fewest_slices = 16;
export const shortest_mm = 20;
/** What the server takes: of one file, as it is sent and unpacked (ingest/dicom/precheck.h), and of one scan (scan.h). */
export const most_file_bytes = 2 ** 30;
export const most_voxels = 2 ** 30;
export const most_slices = 20_000;

const image_root = "1.2.840.10008.5.1.4.1.1.";
const slices_of = new Set(["2", "4", "128", "2.1", "2.2", "4.1", "4.4", "128.1", "130"].map((leaf) => image_root + leaf));

/** Slices of a CT, MR or PET scan; other files are reports, screenshots, plans, structures: never listed. */
export const is_slice = ({ sop_class, voxels, truncated }: SliceHeader): boolean =>
  slices_of.has(sop_class) && (voxels !== null || truncated);

const transfer_syntaxes = new Set([
  "1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.1.99", "1.2.840.10008.1.2.2", "1.2.840.10008.1.2.5",
  "1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51", "1.2.840.10008.1.2.4.57", "1.2.840.10008.1.2.4.70",
  "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.81", "1.2.840.10008.1.2.4.90", "1.2.840.10008.1.2.4.91",
]);

const refuse = (reason: Reason, count = 0): Unsuitable => ({ suitable: false, reason, count });

export function judge(all: readonly SliceHeader[]): Chosen | Unsuitable {
  const of_class = all.filter(is_slice);
  if (of_class.length === 0) return refuse("no_slices", all.length);
  const whole = of_class.filter((slice) => !slice.truncated);
  // A file that was cut off in its header says nothing of how it is coded: the others decide.
  const coded = of_class.filter((slice) => slice.transfer_syntax !== "");
  if (coded.some((slice) => !transfer_syntaxes.has(slice.transfer_syntax))) return refuse("unsupported_compression", of_class.length);
  if (whole.length === 0) return refuse("damaged", of_class.length);
  if (whole.some((slice) => slice.modality !== whole[0]?.modality)) return refuse("mixed", whole.length);
  if (whole.some(is_view)) return refuse("views_not_slices", whole.length);
  if (!whole.every(is_original)) return refuse("not_original");

  const single = without_doubles(whole);
  if (!single) return refuse("repeated_identifier");
  const kept = single.filter((slice) => !slice.image_type.includes("LOCALIZER"));
  if (kept.length === 0) return refuse("scout", single.length);
  if (kept.some((slice) => slice.frames > 1)) return refuse("no_position", kept.length);
  if (kept.some((s) => s.samples !== 1 || !/^MONOCHROME[12]$/.test(s.photometric))) return refuse("screenshots", kept.length);
  return judge_geometry(kept, {
    scouts: single.length - kept.length,
    doubles: whole.length - single.length,
    damaged: of_class.length - whole.length,
    others: 0,
  });
}

const view_marks = ["PROJECTION", "MIP", "MINIP", "ROTAT", "VRT"];
const is_view = (slice: SliceHeader) => slice.image_type.some((part) => view_marks.some((mark) => part.includes(mark)));

/** "MIXED": of frames each of which says it for itself. */
function is_original({ image_type: [first = "", second], is_lossy }: SliceHeader): boolean {
  return first === "" || first === "ORIGINAL" || first === "MIXED" || (first === "DERIVED" && is_lossy && second === "PRIMARY");
}

/** Case 7: the same object twice on the disc; nothing when one identifier stands for two places. */
function without_doubles(slices: readonly SliceHeader[]): SliceHeader[] | null {
  const seen = new Map<string, SliceHeader>();
  const kept: SliceHeader[] = [];
  for (const slice of slices) {
    const key = `${slice.sop_uid} ${slice.frame}`;
    const before = slice.sop_uid ? seen.get(key) : undefined;
    if (before && String(before.position) !== String(slice.position)) return null;
    if (before) continue;
    seen.set(key, slice);
    kept.push(slice);
  }
  return kept;
}

function judge_geometry(slices: readonly SliceHeader[], left_out: LeftOut): Chosen | Unsuitable {
  if (slices.some((s) => !s.position || !s.orientation)) return refuse("no_position", slices.length);
  if (slices.some((s) => !s.pixel_spacing || !(Math.min(...s.pixel_spacing) > 0) || s.rows === 0 || s.columns === 0))
    return refuse("no_spacing", slices.length);
  if (slices.some((s) => !axes_of(s.orientation))) return refuse("bad_orientation", slices.length);
  const turned = groups_of(slices, (a, b) => near(a.orientation, b.orientation, 4e-3));
  const main = largest(turned);
  const strangers = slices.length - main.length;
  if (turned.length > 3 && 2 * strangers > slices.length) return refuse("views_not_slices", slices.length);
  if (strangers > most_strangers && main.length >= fewest_slices) return refuse("mixed", slices.length);

  const even = largest(groups_of(main, same_size));
  const others = main.length - even.length;
  if (even.length < fewest_slices) return refuse(main.length >= fewest_slices ? "mixed" : "too_few_slices", even.length);
  const unscaled = judge_scale(even);
  if (unscaled) return unscaled;
  return judge_stack(even, { ...left_out, scouts: left_out.scouts + strangers, others });
}

/** So many pictures of another direction are scouts without the word; more are another series. */
const most_strangers = 3;

/** Scales of real scans lie far within these bounds, which are those of ingest/dicom/classify.cpp. */
function is_plausible_scale(slice: SliceHeader): boolean {
  const size = Math.abs(slice.slope);
  if (!Number.isFinite(size) || !Number.isFinite(slice.intercept) || size < 1e-12) return false;
  return slice.modality === "CT" ? size <= 1000 && Math.abs(slice.intercept) <= 1e5 : size <= 1e12;
}

function judge_scale(slices: readonly SliceHeader[]): Unsuitable | null {
  if (slices.some((slice) => slice.has_lookup_table)) return refuse("lookup_table");
  if (slices.some((slice) => slice.photometric !== slices[0]?.photometric)) return refuse("mixed", slices.length);
  if (slices.some((slice) => !is_plausible_scale(slice))) return refuse("bad_rescale");
  const unknown = (slice: SliceHeader) => slice.modality === "CT" && !slice.has_scale && !slice.is_signed;
  if (slices.some(unknown)) return refuse("no_rescale");
  if (slices.some((slice) => ![8, 16].includes(slice.bits_allocated))) return refuse("pixel_format");
  return null;
}

function judge_stack(slices: readonly SliceHeader[], left_out: LeftOut): Chosen | Unsuitable {
  const first = slices[0];
  const axes = axes_of(first?.orientation ?? null);
  const positions = slices.flatMap(({ position }) => (position ? [position] : []));
  if (!first?.pixel_spacing || !axes) return refuse("no_position", slices.length);
  const found = arrange(positions, axes, Math.min(...first.pixel_spacing));
  if (!found.volume) return refuse(found.reason === "one_position" && first.stack !== "" ? "cine" : found.reason, found.count);
  const height = found.slices * found.spacing;
  if (height < shortest_mm) return refuse("too_short", Math.round(height));
  if (first.rows * first.columns * found.slices > most_voxels || is_too_large(slices)) return refuse("too_large");
  return {
    suitable: true,
    slices: found.order.flatMap((i) => slices[i] ?? []),
    size: [first.columns, first.rows, found.slices],
    size_mm: [first.columns * first.pixel_spacing[1], first.rows * first.pixel_spacing[0], height],
    left_out,
    repairs: found.repairs,
  };
}

/** Some of a file's pictures may not be chosen, but it is sent as one piece. */
function is_too_large(slices: readonly SliceHeader[]): boolean {
  if (slices.length > most_slices) return true;
  const unpacked = new Map<number, number>();
  for (const { file, rows, columns, bits_allocated } of slices)
    unpacked.set(file, (unpacked.get(file) ?? 0) + (rows * columns * bits_allocated) / 8);
  const sent = ({ voxels }: SliceHeader) => (voxels ? voxels.to - voxels.from : 0);
  return slices.some((slice) => Math.max(sent(slice), unpacked.get(slice.file) ?? 0) > most_file_bytes);
}

/** Nothing when the two directions are not of unit length and at right angles. */
function axes_of(orientation: SliceHeader["orientation"]): Axes | null {
  if (!orientation) return null;
  const [a, b, c, d, e, f] = orientation;
  const row: Vector = [a, b, c];
  const column: Vector = [d, e, f];
  const off = Math.max(Math.abs(Math.hypot(...row) - 1), Math.abs(Math.hypot(...column) - 1), Math.abs(a * d + b * e + c * f));
  return off > 0.01 ? null : { row, column, normal: cross(row, column) };
}

function groups_of(slices: readonly SliceHeader[], same: (a: SliceHeader, b: SliceHeader) => boolean): SliceHeader[][] {
  const groups: SliceHeader[][] = [];
  for (const slice of slices) {
    const group = groups.find(([first]) => first && same(slice, first));
    if (group) group.push(slice);
    else groups.push([slice]);
  }
  return groups;
}

const largest = (groups: readonly SliceHeader[][]): SliceHeader[] => groups.reduce((a, b) => (b.length > a.length ? b : a), []);

const near = (a: readonly number[] | null, b: readonly number[] | null, tolerance: number): boolean =>
  a?.every((value, i) => Math.abs(value - (b?.[i] ?? Number.NaN)) <= tolerance) ?? false;

const same_size = (slice: SliceHeader, first: SliceHeader): boolean =>
  slice.rows === first.rows && slice.columns === first.columns && near(slice.pixel_spacing, first.pixel_spacing, 1e-3);
