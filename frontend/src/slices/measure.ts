import { add, dot, length, scale, subtract, type Vec3 } from "../input/vec3";
import { placeOf, spotOf, type Plane, type Stack } from "./stack";

export const measureKinds = ["ruler", "angle", "ellipse"] as const;
export type MeasureKind = (typeof measureKinds)[number];
const pointsOf: Readonly<Record<MeasureKind, number>> = { ruler: 2, angle: 3, ellipse: 2 };

/**
 * A measurement by points in world space (mm) within one slice. The second point of an angle is its
 * vertex. Those of an ellipse are two opposite corners of the rectangle around it.
 */
export interface Measure {
  readonly kind: MeasureKind;
  /** Null if it was made in an oblique slice. It is shown in every slice that contains it. */
  readonly plane: Plane | null;
  readonly slice: number;
  readonly points: readonly Vec3[];
  /** A third corner of the rectangle around an ellipse without a plane, in the column of the first one. */
  readonly corner?: Vec3;
  /** The saved set that the measurement belongs to. Absent if it is not saved. */
  readonly set?: string;
}

export const isWhole = ({ kind, points }: Measure): boolean => points.length === pointsOf[kind];

/** Returns the length in mm or the angle in degrees, or null while points are missing. */
export function measured({ kind, points }: Measure): number | null {
  const [a, b, c] = points;
  if (!a || !b || kind === "ellipse") return null;
  if (kind === "ruler") return length(subtract(b, a));
  if (!c) return null;
  const one = subtract(a, b);
  const other = subtract(c, b);
  const size = length(one) * length(other);
  return size > 0 ? (180 / Math.PI) * Math.acos(Math.min(1, Math.max(-1, dot(one, other) / size))) : null;
}

/**
 * Adds a point to the last measurement if that is unfinished and of this kind and slice. Otherwise starts a new one.
 */
export function withPoint(
  measures: readonly Measure[],
  kind: MeasureKind,
  plane: Plane | null,
  slice: number,
  point: Vec3,
): readonly Measure[] {
  const done = measures.filter(isWhole);
  const last = measures.at(-1);
  if (!last || isWhole(last) || last.kind !== kind || last.plane !== plane || last.slice !== slice)
    return [...done, { kind, plane, slice, points: [point] }];
  return [...done, { ...last, points: [...last.points, point] }];
}

/** Tolerance in pixels for points that lie in a slice or a row, which are computed with rounding errors. */
const rounding = 1e-3;

/** Whether a slice shows a measurement: it was made there, or lies within the slice. */
export function isInSlice(measure: Measure, stack: Stack, index: number): boolean {
  const { kind, plane, slice, points, corner } = measure;
  if (plane !== null && !stack.oblique) return plane === stack.plane && slice === index;
  const half = Math.max(0.5, (stack.oblique?.slab.mm ?? 0) / 2 / length(stack.next)) + rounding;
  const spots = [...points, ...(corner ? [corner] : [])].map((point) => spotOf(stack, point));
  if (!spots.every((spot) => Math.abs(spot.slice - index) <= half)) return false;
  const [a, b, third] = spots;
  if (kind !== "ellipse" || !a || !b) return true;
  return third !== undefined && Math.abs(third.column - a.column) + Math.abs(third.row - b.row) < 2 * rounding;
}

/** Notes the direction of an ellipse that was made or changed in a slice of `stack`. */
export function withCorner(stack: Stack, measure: Measure): Measure {
  const [a, b] = measure.points;
  if (measure.plane !== null || measure.kind !== "ellipse" || !a || !b) return measure;
  const [one, other] = [spotOf(stack, a), spotOf(stack, b)];
  return { ...measure, corner: placeOf(stack, { ...one, row: other.row }) };
}

/** Moves the last point of the last measurement, while it is dragged. */
export function withLastPoint(measures: readonly Measure[], point: Vec3): readonly Measure[] {
  const last = measures.at(-1);
  return last ? [...measures.slice(0, -1), { ...last, points: [...last.points.slice(0, -1), point] }] : measures;
}

/** Removes the last measurement, which may be unfinished. */
export const withoutLast = (measures: readonly Measure[]): readonly Measure[] => measures.slice(0, -1);

/**
 * Returns the points by which a measurement can be changed. Those of an ellipse are its left, right, upper and lower
 * ends, which resize it, and its centre, which moves it.
 */
export function handlesOf(stack: Stack, { kind, points }: Measure): readonly Vec3[] {
  const [a, b] = points;
  if (kind !== "ellipse" || !a || !b) return points;
  const [one, other] = [spotOf(stack, a), spotOf(stack, b)];
  const column = (one.column + other.column) / 2;
  const row = (one.row + other.row) / 2;
  return [
    placeOf(stack, { ...one, row }),
    placeOf(stack, { ...other, row }),
    placeOf(stack, { ...one, column }),
    placeOf(stack, { ...other, column }),
    placeOf(stack, { ...one, column, row }),
  ];
}

/** Moves a handle to a point. */
export function withHandle(stack: Stack, measure: Measure, handle: number, to: Vec3): Measure {
  const { kind, points } = measure;
  const [a, b] = points;
  if (kind !== "ellipse" || !a || !b) return { ...measure, points: points.map((old, i) => (i === handle ? to : old)) };
  if (handle === 4) {
    const by = subtract(to, scale(add(a, b), 0.5));
    return { ...measure, points: [add(a, by), add(b, by)] };
  }
  const { column, row } = spotOf(stack, to);
  const changed = handle < 2 ? { column } : { row };
  return {
    ...measure,
    points: points.map((old, i) => (i === handle % 2 ? placeOf(stack, { ...spotOf(stack, old), ...changed }) : old)),
  };
}

/** A handle of a measurement, by the indices of both. */
export interface Held {
  readonly measure: number;
  readonly handle: number;
}

/** Returns the nearest handle in a slice within `reach` mm of a point. Of equally near ones, the newest. */
export function handleNear(
  measures: readonly Measure[],
  stack: Stack,
  slice: number,
  place: Vec3,
  reach: number,
): Held | null {
  let nearest: Held | null = null;
  let least = reach;
  measures.forEach((one, measure) => {
    if (!isInSlice(one, stack, slice) || !isWhole(one)) return;
    handlesOf(stack, one).forEach((at, handle) => {
      const away = length(subtract(at, place));
      if (away > least) return;
      least = away;
      nearest = { measure, handle };
    });
  });
  return nearest;
}
