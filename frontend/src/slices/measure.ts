import { dot, length, subtract, type Vec3 } from "../input/vec3";
import type { Plane } from "./stack";

export type MeasureKind = "ruler" | "angle";
const pointsOf: Readonly<Record<MeasureKind, number>> = { ruler: 2, angle: 3 };

/** Points in world space, mm; of an angle the second is its corner. In one slice. */
export interface Measure {
  readonly kind: MeasureKind;
  readonly plane: Plane;
  readonly slice: number;
  readonly points: readonly Vec3[];
}

export const isWhole = ({ kind, points }: Measure): boolean => points.length === pointsOf[kind];

/** mm, or degrees; nothing while points are lacking. */
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

/** Another point, into the last measure if that is one of this kind and slice that lacks some; else it begins one. */
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

/** The last point of the last measure elsewhere, as a hand drags it. */
export function withLastPoint(measures: readonly Measure[], point: Vec3): readonly Measure[] {
  const last = measures.at(-1);
  return last ? [...measures.slice(0, -1), { ...last, points: [...last.points.slice(0, -1), point] }] : measures;
}

/** Without the last: the one that is being made, where one is. */
export const withoutLast = (measures: readonly Measure[]): readonly Measure[] => measures.slice(0, -1);
