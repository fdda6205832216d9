import { dot, length, subtract, type Vec3 } from "../input/vec3";
import type { Plane } from "./stack";

export type MeasureKind = "ruler" | "angle";
const pointsOf: Readonly<Record<MeasureKind, number>> = { ruler: 2, angle: 3 };

/** Points in world space (mm) within one slice. The second point of an angle is its vertex. */
export interface Measure {
  readonly kind: MeasureKind;
  readonly plane: Plane;
  readonly slice: number;
  readonly points: readonly Vec3[];
}

export const isWhole = ({ kind, points }: Measure): boolean => points.length === pointsOf[kind];

/** Returns mm or degrees, or null while points are missing. */
export function measured({ kind, points }: Measure): number | null {
  const [a, b, c] = points;
  if (!a || !b) return null;
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
  plane: Plane,
  slice: number,
  point: Vec3,
): readonly Measure[] {
  const done = measures.filter(isWhole);
  const last = measures.at(-1);
  if (!last || isWhole(last) || last.kind !== kind || last.plane !== plane || last.slice !== slice)
    return [...done, { kind, plane, slice, points: [point] }];
  return [...done, { ...last, points: [...last.points, point] }];
}

/** Moves the last point of the last measurement, while it is dragged. */
export function withLastPoint(measures: readonly Measure[], point: Vec3): readonly Measure[] {
  const last = measures.at(-1);
  return last ? [...measures.slice(0, -1), { ...last, points: [...last.points.slice(0, -1), point] }] : measures;
}

/** Removes the last measurement, which may be unfinished. */
export const withoutLast = (measures: readonly Measure[]): readonly Measure[] => measures.slice(0, -1);
