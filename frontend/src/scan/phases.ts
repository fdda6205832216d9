import { dot, type Axes, type Vector } from "./stack";
import type { PhaseKind, Reason, SliceHeader } from "./types";

/**
 * Splits the slices of a series that share positions into phases, by the same rules as ingest/dicom/phases.cpp. Pure
 * functions.
 */

/** Indices into SliceHeader.moment: what may distinguish slices at the same position, in the order of preference. */
export const distinctions = [
  "b_value",
  "echo",
  "cycle",
  "trigger",
  "offset",
  "temporal_position",
  "image_type",
  "acquisition_time",
  "content_time",
  "instance",
] as const;
export type Distinction = (typeof distinctions)[number];

export type Moment = readonly (number | null)[];

const kinds: Readonly<Partial<Record<Distinction, PhaseKind>>> = {
  b_value: "b_value",
  echo: "echo",
  cycle: "cycle",
  trigger: "time",
  offset: "time",
};

const jitterMm = 0.01;
const leastCommon = 0.9;
const leastComplete = 0.5;

export type SplitPhases =
  | { readonly reason: Reason }
  | {
      readonly kind: PhaseKind;
      readonly by: Distinction;
      /** The slices of each phase, in the order of their positions. */
      readonly phases: readonly (readonly SliceHeader[])[];
      /** Values of the first and the last phase, in the unit of `kind`. */
      readonly range: readonly [number, number];
      readonly incomplete: number;
      readonly uncommon: number;
    };

/** Returns the slices in groups of the same position, in the order of the positions. */
export function placesOf(slices: readonly SliceHeader[], axes: Axes): SliceHeader[][] {
  const placed = slices
    .map((slice) => ({ slice, along: dot(slice.position as Vector, axes.normal) }))
    .sort((a, b) => a.along - b.along);
  const places: SliceHeader[][] = [];
  placed.forEach(({ slice, along }, i) => {
    const before = placed[i - 1];
    if (!before || along - before.along > jitterMm) places.push([]);
    places.at(-1)?.push(slice);
  });
  return places;
}

/** Whether a series repeats its positions often enough to have phases. */
export const hasPhases = (places: readonly SliceHeader[][], slices: number): boolean =>
  places.length > 1 && slices > places.length && slices >= 2 * places.length - Math.floor(places.length / 10);

/** Precondition: hasPhases(). `pixel` is the smaller pixel spacing in mm. */
export function splitPhases(places: readonly SliceHeader[][], pixel: number): SplitPhases {
  if (!places.every((place) => isAligned(place, pixel))) return { reason: "shifted_slices" };
  const key = keysOf(places.flat());
  const by = distinctions.findIndex((_, i) => distinguishes(places, (slice) => key(slice)[i] ?? null));
  const last = distinctions.length - 1;
  const main = by < 0 ? last : by;
  const sorted = places.map((place) => [...place].sort((a, b) => compare(key(a), key(b), main)));
  const equal = sorted.every(({ length }) => length === sorted[0]?.length);
  const grid = equal ? byRank(sorted) : byValue(sorted, (slice) => key(slice)[main] ?? 0);
  const { phases, incomplete, uncommon } = keepComplete(grid, places.length);
  if (phases.length === 0 || phases.length < leastComplete * grid.length) return { reason: "incomplete_phases" };
  const named = distinctions[main] ?? "instance";
  const kind = kinds[named] ?? "index";
  const valueOf = (phase: readonly SliceHeader[] | undefined) => median((phase ?? []).map((s) => key(s)[main] ?? 0));
  const [from, to] = [valueOf(phases[0]), valueOf(phases.at(-1))];
  const range =
    kind === "index"
      ? ([0, phases.length - 1] as const)
      : kind === "time"
        ? ([0, to - from] as const)
        : ([from, to] as const);
  return { kind, by: named, phases, range, incomplete, uncommon };
}

function isAligned(place: readonly SliceHeader[], pixel: number): boolean {
  const first = place[0]?.position ?? [0, 0, 0];
  return place.every(
    ({ position }) =>
      position !== null &&
      Math.hypot(position[0] - first[0], position[1] - first[1], position[2] - first[2]) <=
        Math.max(2 * jitterMm, 0.1 * pixel),
  );
}

/** Returns a function that gives the numbers of a slice by distinction, including those of image types and instances. */
function keysOf(slices: readonly SliceHeader[]): (slice: SliceHeader) => Moment {
  const types = [...new Set(slices.map(({ imageType }) => imageType.join("\\")))].sort();
  const framesPerInstance = 1e5;
  return ({ moment, imageType, frame }) =>
    distinctions.map((name, i) => {
      if (name === "image_type") return types.indexOf(imageType.join("\\"));
      return name === "instance" ? (moment[i] ?? 0) * framesPerInstance + frame : (moment[i] ?? null);
    });
}

/** Whether all slices have this number, and it differs within each place. */
const distinguishes = (places: readonly SliceHeader[][], numberOf: (slice: SliceHeader) => number | null): boolean =>
  places.every((place) => {
    const values = place.map(numberOf);
    return !values.includes(null) && (place.length === 1 || new Set(values).size > 1);
  });

function compare(a: Moment, b: Moment, main: number): number {
  for (const i of [main, ...a.keys()]) {
    const order = (a[i] ?? -Infinity) - (b[i] ?? -Infinity);
    if (order > 0 || order < 0) return order;
  }
  return 0;
}

type Grid = (SliceHeader | undefined)[][];

/** Assigns the n-th slice of each place to the n-th phase. */
const byRank = (places: readonly SliceHeader[][]): Grid =>
  (places[0] ?? []).map((_, phase) => places.map((place) => place[phase]));

/** Assigns slices with the same number to a phase. Returns an empty grid if that is ambiguous. */
function byValue(places: readonly SliceHeader[][], numberOf: (slice: SliceHeader) => number): Grid {
  const phases = new Map<number, (SliceHeader | undefined)[]>();
  for (const [p, place] of places.entries())
    for (const slice of place) {
      const value = numberOf(slice);
      const phase = phases.get(value) ?? Array.from({ length: places.length }, () => undefined);
      if (phase[p]) return [];
      phase[p] = slice;
      phases.set(value, phase);
    }
  const most = Math.max(...places.map(({ length }) => length));
  if (phases.size !== most) return [];
  return [...phases].sort(([a], [b]) => a - b).map(([, phase]) => phase);
}

/** The first and one past the last place of a phase, or an empty range if it has gaps. */
function rangeOf(phase: readonly (SliceHeader | undefined)[]): readonly [number, number] {
  const first = phase.findIndex(Boolean);
  const end = phase.findLastIndex(Boolean) + 1;
  return phase.slice(first, end).every(Boolean) ? [first, end] : [0, 0];
}

/** Leaves out phases until the others have most places in common, and keeps those places. */
function keepComplete(grid: Grid, places: number) {
  const kept = grid.map((phase) => ({ phase, range: rangeOf(phase) }));
  const length = ([from, to]: readonly [number, number]) => to - from;
  let [low, high] = [0, 0];
  while (kept.length > 0) {
    low = Math.max(...kept.map(({ range }) => range[0]));
    high = Math.min(...kept.map(({ range }) => range[1]));
    if (high >= low + leastCommon * places) break;
    const shortest = kept.reduce(
      (best, { range }, i) => (length(range) < length(kept[best]?.range ?? range) ? i : best),
      0,
    );
    kept.splice(shortest, 1);
  }
  return {
    phases: kept.map(({ phase }) => phase.slice(low, high).flatMap((slice) => slice ?? [])),
    incomplete: grid.length - kept.length,
    uncommon: kept.reduce((sum, { range }) => sum + length(range) - (high - low), 0),
  };
}

function median(values: readonly number[]): number {
  return [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)] ?? 0;
}

/** Returns every n-th phase so that at most `most` remain. */
export function thinned<T>(phases: readonly T[], most: number): readonly T[] {
  const step = Math.ceil(phases.length / Math.max(1, most));
  return step <= 1 ? phases : phases.filter((_, i) => i % step === 0);
}
