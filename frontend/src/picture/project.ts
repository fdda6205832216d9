import type { Area, Point } from "../input/flat";
import { orbitFrame, orbitOf, type CameraFrame, type CameraPose } from "../input/camera";
import { add, dot, scale, subtract, vec3, type Vec3 } from "../input/vec3";
import { across } from "../scene/direction";

/** A camera, as much of it as decides where something is in the picture. */
export interface Eye extends CameraPose {
  /** mm that the picture is high at any depth; absent or 0: perspective. */
  readonly orthographicHeight?: number;
}

export interface Box {
  readonly low: Vec3;
  readonly high: Vec3;
}

export type Axis = "x" | "y" | "z";

export const frameOf = (eye: CameraPose): CameraFrame => orbitFrame(orbitOf(eye));

/** How many pixels a mm is at so many mm ahead of the eye. */
const pixelsPerMm = (eye: Eye, screen: Area, ahead: number): number =>
  eye.orthographicHeight
    ? screen.height / eye.orthographicHeight
    : screen.height / 2 / Math.tan((eye.verticalFovDegrees * Math.PI) / 360) / ahead;

/** Nothing for what lies behind the eye. */
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

/** The place, no nearer and no farther than `place`, that is seen so many pixels beside it. */
export function beside(eye: Eye, screen: Area, place: Vec3, by: Point): Vec3 {
  const frame = frameOf(eye);
  const mm = 1 / pixelsPerMm(eye, screen, Math.max(1, -dot(subtract(place, eye.eye), frame.back)));
  return add(place, add(scale(frame.right, by.x * mm), scale(frame.up, -by.y * mm)));
}

/**
 * How many mm along `along` a hand means that moves by so many pixels. Nothing when the way points at the viewer, so that
 * a pixel would be too far to be meant.
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

/** Pairs of corners. */
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

/** Where the plane of that unit normal, so far from the middle along it, meets the box: corners in order around, or none. */
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

/** Where a handle for a face of the box stands, and the way in which it goes. */
export function faceOf(box: Box, axis: Axis, side: "low" | "high"): { readonly place: Vec3; readonly along: Vec3 } {
  const middle = scale(add(box.low, box.high), 0.5);
  const along = vec3(Number(axis === "x"), Number(axis === "y"), Number(axis === "z"));
  return { place: { ...middle, [axis]: box[side][axis] }, along };
}

/** Pixels: the side of a handle's target (style/picture.css). */
export const handlePx = 44;

/**
 * Of those that would lie on each other the one with the lowest rank: another would be hit by chance. The sliders are the
 * way to it meanwhile.
 */
export function apart<Item extends Point>(items: readonly Item[], rank: (item: Item) => number): Item[] {
  const taken: Item[] = [];
  for (const one of [...items].sort((a, b) => rank(a) - rank(b))) {
    if (taken.every(({ x, y }) => Math.hypot(x - one.x, y - one.y) >= handlePx)) taken.push(one);
  }
  return items.filter((one) => taken.includes(one));
}
