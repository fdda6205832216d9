import type { Reason, Repair } from "./types";

/**
 * Arranges the slices of a series along their normal, by the same rules as ingest/dicom/stack.cpp but without planning
 * the volume. Pure functions.
 */

export type Vector = readonly [number, number, number];
export const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Vector, b: Vector): Vector => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const minus = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

export interface Axes {
  readonly row: Vector;
  readonly column: Vector;
  readonly normal: Vector;
}

export type Arranged =
  | { readonly volume: false; readonly reason: Reason; readonly count: number }
  | {
      readonly volume: true;
      /** Indices of the positions, sorted by distance along the normal. */
      readonly order: readonly number[];
      readonly slices: number;
      readonly spacing: number;
      readonly repairs: readonly Repair[];
    };

const jitterMm = 0.01;
const jitterShare = 0.02;
const rounding = 1e-6;
const steepestShear = 0.1;
const steepestTilt = 45;
const mostMissing = 0.05;
const largestGap = 3;
const mostVarying = 8;

const toleranceOf = (spacing: number) => Math.max(jitterMm, jitterShare * spacing);
const no = (reason: Reason, count = 0): Arranged => ({ volume: false, reason, count });
const sum = (values: readonly number[]) => values.reduce((a, b) => a + b, 0);

/**
 * Arranges the slices at these positions. `pixel` is the smaller pixel spacing in mm. Precondition:
 * at least two positions.
 */
export function arrange(positions: readonly Vector[], axes: Axes, pixel: number): Arranged {
  const placed = positions
    .map((at, index) => ({ at, index, along: dot(at, axes.normal) }))
    .sort((a, b) => a.along - b.along);
  const first = placed[0];
  const last = placed.at(-1);
  if (!first || !last) return no("too_few_slices");
  const gaps = placed.slice(1).map(({ along }, i) => along - (placed[i]?.along ?? 0));
  const places = 1 + gaps.filter((gap) => gap > jitterMm).length;
  if (places === 1) return no("one_position", placed.length);
  if (places < placed.length) return no("repeated_position", placed.length);

  const extent = minus(last.at, first.at);
  const height = dot(extent, axes.normal);
  const [shiftX, shiftY] = [dot(extent, axes.row), dot(extent, axes.column)];
  const shear = (Math.atan2(Math.hypot(shiftX, shiftY), height) * 180) / Math.PI;
  if (shear > steepestTilt) return no("tilted");
  const spacing = height / gaps.length;
  let jitter = 0;
  let sideways = 0;
  placed.forEach(({ at }, i) => {
    const here = minus(at, first.at);
    const up = dot(here, axes.normal);
    jitter = Math.max(jitter, Math.abs(up - i * spacing));
    const share = up / height;
    sideways = Math.max(
      sideways,
      Math.hypot(dot(here, axes.row) - share * shiftX, dot(here, axes.column) - share * shiftY),
    );
  });
  if (sideways > Math.max(jitterMm, 0.1 * pixel)) return no("shifted_slices");

  const straightened: Repair[] = shear > steepestShear ? [{ kind: "straightened", degrees: shear }] : [];
  const order = placed.map(({ index }) => index);
  const tolerance = toleranceOf(spacing) + rounding;
  const gapError = Math.max(...gaps.map((gap) => Math.abs(gap - spacing)));
  if (jitter <= tolerance || (gapError <= tolerance && jitter <= spacing / 4))
    return { volume: true, order, slices: order.length, spacing, repairs: straightened };
  const uneven = judgeUneven(gaps, height);
  if ("reason" in uneven) return no(uneven.reason, uneven.count);
  return {
    volume: true,
    order,
    slices: uneven.slices,
    spacing: height / (uneven.slices - 1),
    repairs: [...straightened, uneven.repair],
  };
}

type Uneven =
  { readonly reason: Reason; readonly count: number } | { readonly slices: number; readonly repair: Repair };

function judgeUneven(gaps: readonly number[], height: number): Uneven {
  const sorted = [...gaps].sort((a, b) => a - b);
  const mains = mainGaps(gaps);
  if (mains.length < 2) {
    const steps = wholeSteps(gaps, mains[0] ?? sorted[Math.floor(sorted.length / 2)] ?? 1);
    if (hasHoles(steps, gaps, height)) {
      const slices = 1 + sum(steps);
      const missing = sum(steps) - steps.length;
      if (missing > mostMissing * slices || Math.max(...steps) > largestGap)
        return { reason: "missing_slices", count: missing };
      return { slices, repair: { kind: "filled_in", slices: missing } };
    }
  }
  const [least, most] = [sorted[0] ?? 1, sorted.at(-1) ?? 1];
  if (most > mostVarying * least) return { reason: "varying_spacing", count: 0 };
  const target = mains[0] ?? sorted[Math.floor(sorted.length / 10)] ?? least;
  return { slices: 1 + Math.ceil(height / target - 0.01), repair: { kind: "varying", fromMm: least, toMm: most } };
}

const alike = (a: number, b: number) => Math.abs(a - b) <= 2 * toleranceOf(Math.min(a, b)) + rounding;

/**
 * Returns the distances that several successive slices share, which are those that the scanner was set to. A gap of a
 * missing slice stands alone.
 */
function mainGaps(gaps: readonly number[]): number[] {
  const found: number[] = [];
  for (let from = 0; from < gaps.length;) {
    let to = from + 1;
    while (to < gaps.length && alike(gaps[from] ?? 0, gaps[to] ?? 0)) to += 1;
    const mean = sum(gaps.slice(from, to)) / (to - from);
    if (to - from >= 3 && !found.some((gap) => alike(gap, mean))) found.push(mean);
    from = to;
  }
  return found.sort((a, b) => a - b);
}

/** Returns the size of each gap in steps of `usual`. Empty if a gap is not a multiple of it. */
function wholeSteps(gaps: readonly number[], usual: number): number[] {
  const steps = gaps.map((gap) => Math.round(gap / usual));
  const fits = steps.every((n, i) => n >= 1 && Math.abs((gaps[i] ?? 0) - n * usual) <= 2 * toleranceOf(usual) * n);
  return fits ? steps : [];
}

/** Whether missing slices alone explain the uneven spacing: with the gaps filled, each slice is near its position. */
function hasHoles(steps: readonly number[], gaps: readonly number[], height: number): boolean {
  const all = sum(steps);
  if (steps.length === 0 || all === steps.length) return false;
  const spacing = height / all;
  let at = 0;
  let place = 0;
  return steps.every((n, i) => {
    at += gaps[i] ?? 0;
    place += n * spacing;
    return Math.abs(at - place) <= spacing / 4;
  });
}
