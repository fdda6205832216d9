import { add, cross, dot, isNumber, isPoint, length, normalize, scale, vec3, type Vec3 } from "../input/vec3";
import { clamp } from "../scene/numbers";
import { planes, type Plane, type Stack } from "./stack";

/** The directions of a plane as perpendicular unit vectors. */
export interface Axes {
  readonly right: Vec3;
  readonly down: Vec3;
}
/** The directions of the three planes, which stay perpendicular to each other. */
export type Tilt = Readonly<Record<Plane, Axes>>;

export const projections = ["mean", "maximum", "minimum"] as const;
export type Projection = (typeof projections)[number];

/** The thickness of the slices in mm, and how their samples are combined. With 0, they are planes. */
export interface Slab {
  readonly mm: number;
  readonly projection: Projection;
}
export const noSlab: Slab = { mm: 0, projection: "mean" };
export const slabLimits = { low: 0, high: 100 } as const;

/** Limits of the server (volume/oblique.h). */
export const mostSide = 2048;
export const mostSamples = 2 ** 25;

/** Returns the directions of the server's stacks, which lie along the patient's axes. */
export function straightTilt(stacks: ReadonlyMap<Plane, Stack>): Tilt | null {
  const axes = planes.map((plane) => {
    const stack = stacks.get(plane);
    return stack && ([plane, unitAxes(stack)] as const);
  });
  return axes.every((one) => one !== undefined) ? (Object.fromEntries(axes) as unknown as Tilt) : null;
}

export const unitAxes = ({ right, down }: Axes): Axes => ({ right: unit(right), down: unit(down) });
const unit = (vector: Vec3): Vec3 => normalize(vector, vec3(1, 0, 0));
export const normalOf = ({ right, down }: Axes): Vec3 => cross(right, down);

function rotated(vector: Vec3, axis: Vec3, angle: number): Vec3 {
  const along = scale(axis, dot(axis, vector) * (1 - Math.cos(angle)));
  return add(add(scale(vector, Math.cos(angle)), scale(cross(axis, vector), Math.sin(angle))), along);
}

/**
 * Turns the other two planes about the normal of a plane, clockwise in its view. The errors of many
 * turns do not add up, because the directions are made perpendicular again.
 */
export function turned(tilt: Tilt, plane: Plane, angle: number): Tilt {
  const axis = unit(normalOf(tilt[plane]));
  const turn = (axes: Axes): Axes => {
    const right = unit(rotated(axes.right, axis, angle));
    const down = rotated(axes.down, axis, angle);
    return { right, down: unit(add(down, scale(right, -dot(right, down)))) };
  };
  const one = (name: Plane): Axes => (name === plane ? tilt[name] : turn(tilt[name]));
  return { axial: one("axial"), sagittal: one("sagittal"), coronal: one("coronal") };
}

/** Returns the angle between a plane and the patient's axes in degrees. */
export function tiltDegrees({ right, down }: Axes, straight: Axes): number {
  const cosine = dot(normalOf({ right, down }), normalOf(straight));
  return (180 / Math.PI) * Math.acos(clamp(cosine, -1, 1));
}

export interface ObliqueParts {
  /** The server's stack of the plane. */
  readonly straight: Stack;
  readonly axes: Axes;
  readonly slab: Slab;
  /** The smallest distance of stored voxels in mm. */
  readonly spacing: number;
  /** A number for this direction and slab. */
  readonly id: number;
}

const odd = (count: number): number => 2 * Math.floor(count / 2) + 1;

/**
 * Returns the slices of a tilted plane. They have the same size in every direction, so that a view keeps its scale while
 * it is turned. Slices are one step apart, which is the smallest one of the server's stacks. So are pixels, unless the
 * slab would need too many samples.
 */
export function obliqueStack({ straight, axes, slab, spacing, id }: ObliqueParts): Stack {
  const sides = [straight.right, straight.down, straight.next];
  const counts = [straight.columns, straight.rows, straight.slices];
  const step = Math.min(...sides.map(length));
  const box = sides.map((side, i) => scale(side, counts[i] ?? 1));
  const diagonal = Math.hypot(...box.map(length));
  const layers = slab.mm > 0 ? 1 + Math.ceil(slab.mm / spacing) : 1;
  const most = Math.min(mostSide, Math.floor(Math.sqrt(mostSamples / layers))) - 1;
  const wanted = Math.ceil(diagonal / step);
  const side = odd(Math.min(wanted, most));
  const pixel = wanted <= most ? step : diagonal / side;
  const sign = Math.sign(dot(cross(straight.right, straight.down), straight.next)) || 1;
  const normal = scale(normalOf(axes), sign);
  const depth = box.reduce((sum, edge) => sum + Math.abs(dot(edge, normal)), 0);
  const slices = odd(Math.ceil(depth / step));
  const right = scale(axes.right, pixel);
  const down = scale(axes.down, pixel);
  const next = scale(normal, step);
  const half = (count: number, vector: Vec3) => scale(vector, -(count - 1) / 2);
  return {
    plane: straight.plane,
    columns: side,
    rows: side,
    slices,
    first: add(add(half(side, right), half(side, down)), half(slices, next)),
    right,
    down,
    next,
    oblique: {
      id,
      slab,
      fit: { width: straight.columns * length(straight.right), height: straight.rows * length(straight.down) },
    },
  };
}

/** Returns the direction, in a view of `stack`, of the line in which another plane cuts it. */
export function traceOf(stack: Stack, other: Stack): { readonly x: number; readonly y: number } {
  const line = cross(stack.next, other.next);
  const x = dot(line, stack.right) / length(stack.right);
  const y = dot(line, stack.down) / length(stack.down);
  const size = Math.hypot(x, y);
  return size > 0 ? { x: x / size, y: y / size } : { x: 1, y: 0 };
}

/** Parses a remembered tilt. Returns null if it is damaged. */
export function tiltFrom(value: unknown): Tilt | null {
  const tilt = value as Partial<Record<Plane, Partial<Record<keyof Axes, unknown>>>> | null | undefined;
  return planes.every((plane) => isPoint(tilt?.[plane]?.right) && isPoint(tilt[plane].down)) ? (tilt as Tilt) : null;
}

export function slabFrom(value: unknown): Slab {
  const slab = value as Partial<Record<keyof Slab, unknown>> | null | undefined;
  const projection = projections.find((one) => one === slab?.projection) ?? noSlab.projection;
  return { mm: isNumber(slab?.mm) ? clamp(slab.mm, slabLimits.low, slabLimits.high) : 0, projection };
}
