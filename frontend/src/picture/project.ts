import type { Area, Point } from "../input/flat";
import { orbitFrame, orbitOf, type CameraFrame, type CameraPose } from "../input/camera";
import { add, dot, scale, subtract, vec3, type Vec3 } from "../input/vec3";
import { across } from "../scene/direction";

/** The part of a camera that determines where points appear in the picture. */
export interface Eye extends CameraPose {
  /** Height of the orthographic picture in mm. Absent or 0 for a perspective picture. */
  readonly orthographicHeight?: number;
}

export interface Box {
  readonly low: Vec3;
  readonly high: Vec3;
}

export type Axis = "x" | "y" | "z";

export const frameOf = (eye: CameraPose): CameraFrame => orbitFrame(orbitOf(eye));

/** Returns the size of one mm in pixels at the distance `ahead` (mm) from the eye. */
const pixelsPerMm = (eye: Eye, screen: Area, ahead: number): number =>
  eye.orthographicHeight
    ? screen.height / eye.orthographicHeight
    : screen.height / 2 / Math.tan((eye.verticalFovDegrees * Math.PI) / 360) / ahead;

/** Projects a point to pixels of the screen. Returns null for a point behind the eye. */
export function onScreen(eye: Eye, screen: Area, place: Vec3): Point | null {
  const frame = frameOf(eye);
  const fromEye = subtract(place, eye.eye);
  const ahead = -dot(fromEye, frame.back);
  if (ahead < 1) return null;
  const pixels = pixelsPerMm(eye, screen, ahead);
  return {
    x: screen.width / 2 + dot(fromEye, frame.right) * pixels,
    y: screen.height / 2 - dot(fromEye, frame.up) * pixels,
  };
}

/** Returns the point at the same depth as `place` that appears `by` pixels away from it. */
export function beside(eye: Eye, screen: Area, place: Vec3, by: Point): Vec3 {
  const frame = frameOf(eye);
  const mm = 1 / pixelsPerMm(eye, screen, Math.max(1, -dot(subtract(place, eye.eye), frame.back)));
  return add(place, add(scale(frame.right, by.x * mm), scale(frame.up, -by.y * mm)));
}

/**
 * Returns how many mm along `along` correspond to a drag by `by` pixels. Null if the direction points at the viewer, so
 * that one pixel would move the point too far.
 */
export function dragged(eye: Eye, screen: Area, place: Vec3, along: Vec3, by: Point): number | null {
  const here = onScreen(eye, screen, place),
    ahead = onScreen(eye, screen, add(place, along));
  if (!here || !ahead) return null;
  const x = ahead.x - here.x,
    y = ahead.y - here.y;
  const square = x * x + y * y;
  return square < 0.04 ? null : (by.x * x + by.y * y) / square;
}

export function corners(box: Box): Vec3[] {
  const of = (i: number, bit: number, axis: Axis) => (i & bit ? box.high[axis] : box.low[axis]);
  return [0, 1, 2, 3, 4, 5, 6, 7].map((i) => vec3(of(i, 1, "x"), of(i, 2, "y"), of(i, 4, "z")));
}

/** Edges as pairs of corners. */
export const edges: readonly (readonly [number, number])[] = [
  [0, 1],
  [2, 3],
  [4, 5],
  [6, 7],
  [0, 2],
  [1, 3],
  [4, 6],
  [5, 7],
  [0, 4],
  [1, 5],
  [2, 6],
  [3, 7],
];

export function middleOf(points: readonly Vec3[]): Vec3 | null {
  return points.length === 0 ? null : scale(points.reduce(add), 1 / points.length);
}

/**
 * Returns the corners, in order, of the polygon in which a plane intersects the box. `normal` has unit length, and
 * `offset` is the distance from the middle along it. Empty if there is none.
 */
export function planeInBox(box: Box, normal: Vec3, offset: number): Vec3[] {
  const points = corners(box);
  const crossing: Vec3[] = [];
  for (const [a, b] of edges) {
    const from = points[a],
      to = points[b];
    if (!from || !to) continue;
    const before = dot(normal, from) - offset,
      behind = dot(normal, to) - offset;
    if (before * behind < 0) crossing.push(add(from, scale(subtract(to, from), before / (before - behind))));
  }
  const middle = middleOf(crossing);
  if (!middle) return [];
  const [u, v] = across(normal, vec3(0, 0, 1));
  const angle = (p: Vec3) => Math.atan2(dot(subtract(p, middle), v), dot(subtract(p, middle), u));
  return crossing.sort((p, q) => angle(p) - angle(q));
}

/** Returns the position of the handle of a face of the box, and the direction in which it moves. */
export function faceOf(box: Box, axis: Axis, side: "low" | "high"): { readonly place: Vec3; readonly along: Vec3 } {
  const middle = scale(add(box.low, box.high), 0.5);
  const along = vec3(Number(axis === "x"), Number(axis === "y"), Number(axis === "z"));
  return { place: { ...middle, [axis]: box[side][axis] }, along };
}

/** Size of a handle's target in pixels (style/picture.css). */
export const handlePx = 44;

/**
 * Removes overlapping items except for the one with the lowest rank, because the others would be
 * hit by accident. They stay reachable by their sliders.
 */
export function apart<Item extends Point>(items: readonly Item[], rank: (item: Item) => number): Item[] {
  const taken: Item[] = [];
  for (const one of [...items].sort((a, b) => rank(a) - rank(b))) {
    if (taken.every(({ x, y }) => Math.hypot(x - one.x, y - one.y) >= handlePx)) taken.push(one);
  }
  return items.filter((one) => taken.includes(one));
}
