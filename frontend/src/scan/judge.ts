import type { LeftOut, Reason, SliceHeader, Suitable, Unsuitable } from "./types";

/**
 * Whether the files of one series can become a volume, by the cases of ingest. Never trusts SliceThickness,
 * SpacingBetweenSlices or InstanceNumber. A preview for the person: the server judges again.
 */

export const fewest_slices = 16;
export const shortest_mm = 20;

const image_classes: Readonly<Record<string, "plain" | "multi_frame" | "screenshots">> = {
  "1.2.840.10008.5.1.4.1.1.2": "plain", // CT
  "1.2.840.10008.5.1.4.1.1.4": "plain", // MR
  "1.2.840.10008.5.1.4.1.1.128": "plain", // PET
  "1.2.840.10008.5.1.4.1.1.2.1": "multi_frame", // enhanced CT
  "1.2.840.10008.5.1.4.1.1.2.2": "multi_frame", // legacy converted enhanced CT
  "1.2.840.10008.5.1.4.1.1.4.1": "multi_frame", // enhanced MR
  "1.2.840.10008.5.1.4.1.1.4.4": "multi_frame",
  "1.2.840.10008.5.1.4.1.1.128.1": "multi_frame",
  "1.2.840.10008.5.1.4.1.1.130": "multi_frame",
  "1.2.840.10008.5.1.4.1.1.7": "screenshots", // secondary capture
  "1.2.840.10008.5.1.4.1.1.7.1": "screenshots",
  "1.2.840.10008.5.1.4.1.1.7.2": "screenshots",
  "1.2.840.10008.5.1.4.1.1.7.3": "screenshots",
  "1.2.840.10008.5.1.4.1.1.7.4": "screenshots",
};

const transfer_syntaxes = new Set([
  "1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2", "1.2.840.10008.1.2.5", // not deflated: names cannot be cut out
  "1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51", "1.2.840.10008.1.2.4.57", "1.2.840.10008.1.2.4.70",
  "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.81", "1.2.840.10008.1.2.4.90", "1.2.840.10008.1.2.4.91",
]);

type Vector = readonly [number, number, number];
const dot = (a: Vector, b: Vector) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Vector, b: Vector): Vector => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

const refuse = (reason: Reason, count = 0): Unsuitable => ({ suitable: false, reason, count });

export function judge(all: readonly SliceHeader[]): Suitable | Unsuitable {
  const of_class = all.filter((slice) => image_classes[slice.sop_class] === "plain");
  if (of_class.length === 0) return without_slices(all);
  if (of_class.some(is_view)) return refuse("views_not_slices", of_class.length);
  if (of_class.some(({ image_type: [first = ""] }) => first !== "" && first !== "ORIGINAL")) return refuse("not_original");

  const single = without_doubles(of_class);
  const kept = single.filter((slice) => !slice.image_type.includes("LOCALIZER"));
  if (kept.length === 0) return refuse("scout", single.length);
  if (kept.some((slice) => slice.frames > 1)) return refuse("multi_frame", kept.length);
  if (kept.some((s) => s.samples !== 1 || !/^MONOCHROME[12]$/.test(s.photometric))) return refuse("screenshots", kept.length);
  if (kept.some((slice) => !transfer_syntaxes.has(slice.transfer_syntax))) return refuse("unsupported_compression", kept.length);

  const whole = kept.filter((slice) => !slice.truncated);
  if (whole.length === 0) return refuse("damaged", kept.length);
  return judge_geometry(whole, {
    scouts: single.length - kept.length,
    doubles: of_class.length - single.length,
    damaged: kept.length - whole.length,
  });
}

function without_slices(all: readonly SliceHeader[]): Unsuitable {
  const kinds = new Set(all.map((slice) => image_classes[slice.sop_class]));
  if (kinds.has("multi_frame")) return refuse("multi_frame", all.length);
  if (kinds.has("screenshots")) return refuse("screenshots", all.length);
  return refuse("no_slices", all.length);
}

const view_marks = ["PROJECTION", "MIP", "MINIP", "ROTAT", "VRT"];
const is_view = (slice: SliceHeader) => slice.image_type.some((part) => view_marks.some((mark) => part.includes(mark)));

/** Case 7: the same object twice on the disc. */
function without_doubles(slices: readonly SliceHeader[]): SliceHeader[] {
  const seen = new Set<string>();
  return slices.filter((slice) => {
    if (!slice.sop_uid) return true;
    if (seen.has(slice.sop_uid)) return false;
    seen.add(slice.sop_uid);
    return true;
  });
}

function judge_geometry(slices: readonly SliceHeader[], left_out: LeftOut): Suitable | Unsuitable {
  if (slices.some((s) => !s.position || !s.orientation || !s.pixel_spacing)) return refuse("no_position", slices.length);
  const [main, others] = by_orientation(slices);
  const first = main[0];
  if (!first?.orientation || !first.pixel_spacing) return refuse("no_position", slices.length);
  if (others > most_strangers && main.length >= fewest_slices) return refuse("mixed", slices.length);
  if (main.length < fewest_slices) return refuse("too_few_slices", main.length);
  if (main.some((slice) => !same_size(slice, first))) return refuse("mixed", main.length);
  if (main.some((slice) => slice.has_lookup_table)) return refuse("lookup_table");
  if (main.some((s) => s.slope !== first.slope || s.intercept !== first.intercept)) return refuse("varying_rescale");

  const [a, b, c, d, e, f] = first.orientation;
  const normal = cross([a, b, c], [d, e, f]);
  const placed = main
    .map((slice) => ({ slice, at: dot(slice.position ?? [0, 0, 0], normal) }))
    .sort((x, y) => x.at - y.at || x.slice.file - y.slice.file);
  const positions = placed.map(({ at }) => at);
  const low = positions[0] ?? 0;
  const high = positions.at(-1) ?? 0;
  const gaps = positions.slice(1).map((at, i) => at - (positions[i] ?? 0));

  const places = 1 + gaps.filter((gap) => gap > jitter_mm).length;
  if (places < main.length) return repeated(places, main.length);
  if (is_sheared(placed[0]?.slice, placed.at(-1)?.slice, normal, high - low)) return refuse("tilted", main.length);
  const spacing = (high - low) / (main.length - 1);
  const uneven = judge_gaps(gaps, spacing);
  if (uneven) return uneven;
  if (spacing * main.length < shortest_mm) return refuse("too_short", Math.round(spacing * main.length));

  const ordered = placed.map(({ slice }) => slice);
  return {
    suitable: true,
    files: ordered.map((slice) => slice.file),
    size: [first.columns, first.rows, ordered.length],
    size_mm: [first.columns * first.pixel_spacing[1], first.rows * first.pixel_spacing[0], ordered.length * spacing],
    left_out: { ...left_out, scouts: left_out.scouts + others },
  };
}

const jitter_mm = 0.01;
/** So many pictures of another direction are scouts without the word; more are another series. */
const most_strangers = 3;

/** Those of the direction that most share, and how many others there are. */
function by_orientation(slices: readonly SliceHeader[]): [SliceHeader[], number] {
  const groups: SliceHeader[][] = [];
  for (const slice of slices) {
    const group = groups.find(([first]) => first && near(slice.orientation, first.orientation, 4e-3));
    if (group) group.push(slice);
    else groups.push([slice]);
  }
  const largest = groups.reduce((a, b) => (b.length > a.length ? b : a), []);
  return [largest, slices.length - largest.length];
}

function repeated(places: number, slices: number): Unsuitable {
  if (places === 1) return refuse("one_position", slices);
  return refuse(slices >= 2 * places - Math.floor(places / 10) ? "time_series" : "repeated_position", slices);
}

const near = (a: readonly number[] | null, b: readonly number[] | null, tolerance: number): boolean =>
  a?.every((value, i) => Math.abs(value - (b?.[i] ?? Number.NaN)) <= tolerance) ?? false;

const same_size = (slice: SliceHeader, first: SliceHeader): boolean =>
  slice.rows === first.rows && slice.columns === first.columns && near(slice.pixel_spacing, first.pixel_spacing, 1e-3);

/** Cases 2, 5 and 6: nothing when the gaps are even. */
function judge_gaps(gaps: readonly number[], mean: number): Unsuitable | null {
  const even = (gap: number, to: number) => Math.abs(gap - to) <= Math.max(jitter_mm, 0.02 * to);
  if (gaps.every((gap) => even(gap, mean))) return null;
  const main = [...gaps].sort((x, y) => x - y)[Math.floor(gaps.length / 2)] ?? mean;
  if (gaps.every((gap) => Math.round(gap / main) >= 1 && even(gap / Math.round(gap / main), main)))
    return refuse("missing_slices", gaps.reduce((sum, gap) => sum + Math.round(gap / main) - 1, 0));
  return refuse("varying_spacing");
}

/** Case 4: the stack leans by more than 0.1 degree. */
function is_sheared(first: SliceHeader | undefined, last: SliceHeader | undefined, normal: Vector, extent: number): boolean {
  const from = first?.position;
  const to = last?.position;
  if (!from || !to) return false;
  const way: Vector = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
  const sideways = Math.hypot(...cross(way, normal));
  return sideways > Math.max(0.05, extent * Math.tan((0.1 * Math.PI) / 180));
}
