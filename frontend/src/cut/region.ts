import type { Area } from "../input/flat";
import { dot, length, scale, subtract, vec3, type Vec3 } from "../input/vec3";
import { apart, faceOf, middleOf, onScreen, planeInBox, type Axis, type Box, type Eye } from "../picture/project";

/** A cutting plane: the direction of its normal and its position. */
export interface FacePlane {
  readonly on: boolean;
  /** In degrees: 0 cuts off the front vertically, and 90 cuts off the bottom horizontally. */
  readonly tilt: number;
  /** In degrees towards the patient's left, for a head that is turned to the side. */
  readonly aside: number;
  /** Distance from the middle of the scan along the normal, in mm. */
  readonly offset: number;
}

/** The region to keep: the part of a box along the patient's axes that lies behind the plane, in mm in world space. */
export interface Region {
  readonly low: Vec3;
  readonly high: Vec3;
  readonly plane: FacePlane;
}

export const leastSideMm = 10;

/**
 * Returns the smallest box along the patient's axes around a volume. The columns of the row-major `direction` are the
 * voxel axes.
 */
export function boundsOf(volume: {
  readonly size: readonly number[];
  readonly spacing: readonly number[];
  readonly direction: readonly number[];
}): Box {
  const half = [0, 1, 2].map((p) =>
    [0, 1, 2].reduce(
      (sum, v) =>
        sum + (Math.abs(volume.direction[3 * p + v] ?? 0) * (volume.spacing[v] ?? 1) * (volume.size[v] ?? 0)) / 2,
      0,
    ),
  );
  const [x = 0, y = 0, z = 0] = half;
  return { low: vec3(-x, -y, -z), high: vec3(x, y, z) };
}

export function planeNormal(plane: FacePlane): Vec3 {
  const down = radians(plane.tilt),
    aside = radians(plane.aside);
  return vec3(Math.cos(down) * Math.sin(aside), -Math.cos(down) * Math.cos(aside), -Math.sin(down));
}

const radians = (degrees: number): number => (degrees * Math.PI) / 180;
const degrees = (angle: number): number => (angle * 180) / Math.PI;

const clamp = (value: number, low: number, high: number): number => Math.min(high, Math.max(low, value));

/** Returns the whole scan. Its plane is off and placed in front of and below the middle. */
export function wholeRegion(bounds: Box): Region {
  const reach = bounds.high.y;
  return { low: bounds.low, high: bounds.high, plane: { on: false, tilt: 50, aside: 0, offset: reach * 0.5 } };
}

/** A region in the form that the API uses. */
export interface RegionBody {
  readonly box: { readonly low: readonly number[]; readonly high: readonly number[] };
  readonly planes?: readonly { readonly point: readonly number[]; readonly normal: readonly number[] }[];
}

const vector = ([x = 0, y = 0, z = 0]: readonly number[]): Vec3 => vec3(x, y, z);
const numbers = (v: Vec3): [number, number, number] => [v.x, v.y, v.z];

export function fromProposal(proposal: RegionBody, bounds: Box): Region {
  const start = wholeRegion(bounds);
  const first = proposal.planes?.[0];
  if (!first) return start;
  const normal = vector(first.normal);
  const tilt = degrees(Math.atan2(-normal.z, Math.hypot(normal.x, normal.y)));
  const plane = { on: true, tilt, aside: degrees(Math.atan2(normal.x, -normal.y)), offset: 0 };
  return { ...start, plane: { ...plane, offset: dot(planeNormal(plane), vector(first.point)) } };
}

export function toBody(region: Region): RegionBody {
  const normal = planeNormal(region.plane);
  const planes = region.plane.on
    ? [{ point: numbers(scale(normal, region.plane.offset)), normal: numbers(normal) }]
    : [];
  return { box: { low: numbers(region.low), high: numbers(region.high) }, planes };
}

export type Handle =
  { readonly kind: "face"; readonly axis: Axis; readonly side: "low" | "high" } | { readonly kind: "plane" };

export const handles: readonly Handle[] = [
  ...(["x", "y", "z"] as const).flatMap((axis) =>
    (["low", "high"] as const).map((side) => ({ kind: "face" as const, axis, side })),
  ),
  { kind: "plane" },
];

/** Returns the position of a handle along its direction and its limits, in mm. */
export function rangeOf(
  handle: Handle,
  region: Region,
  bounds: Box,
): { readonly at: number; readonly low: number; readonly high: number } {
  if (handle.kind === "plane") {
    const normal = planeNormal(region.plane);
    const reach =
      Math.abs(normal.x) * bounds.high.x + Math.abs(normal.y) * bounds.high.y + Math.abs(normal.z) * bounds.high.z;
    return { at: region.plane.offset, low: -reach, high: reach };
  }
  const { axis, side } = handle;
  return side === "low"
    ? { at: region.low[axis], low: bounds.low[axis], high: region.high[axis] - leastSideMm }
    : { at: region.high[axis], low: region.low[axis] + leastSideMm, high: bounds.high[axis] };
}

export function moved(handle: Handle, to: number, region: Region, bounds: Box): Region {
  const { low, high } = rangeOf(handle, region, bounds);
  const at = clamp(to, low, Math.max(low, high));
  if (handle.kind === "plane") return { ...region, plane: { ...region.plane, offset: at } };
  return { ...region, [handle.side]: { ...region[handle.side], [handle.axis]: at } };
}

/**
 * Returns the corners of the polygon in which the plane intersects the box, in order. Empty if there is none or the
 * plane is off.
 */
export const planeInRegion = (region: Region): Vec3[] =>
  region.plane.on ? planeInBox(region, planeNormal(region.plane), region.plane.offset) : [];

/** Returns the position of a handle and the direction in which it moves. */
export function placeOf(handle: Handle, region: Region): { readonly place: Vec3; readonly along: Vec3 } | null {
  if (handle.kind === "face") return faceOf(region, handle.axis, handle.side);
  const place = middleOf(planeInRegion(region));
  return place && { place, along: planeNormal(region.plane) };
}

export interface PlacedHandle {
  readonly handle: Handle;
  readonly place: Vec3;
  readonly along: Vec3;
  readonly x: number;
  readonly y: number;
}

/**
 * Returns the handles that can be dragged, with their positions on the screen. Where handles overlap, only one is
 * returned: the held one, else that of the plane, else the nearest.
 */
export function handlesToTake(eye: Eye, screen: Area, region: Region, held: Handle | null): PlacedHandle[] {
  const placed = handles.flatMap((handle) => {
    const where = placeOf(handle, region);
    const point = where && onScreen(eye, screen, where.place);
    return point ? [{ handle, ...where, ...point }] : [];
  });
  return apart(placed, ({ handle, place }) =>
    handle === held ? -2 : handle.kind === "plane" ? -1 : length(subtract(place, eye.eye)),
  );
}

/** Estimates the part of the scan that is cut away, from 0 to 1, on a coarse lattice. Only for display. */
export function partThatGoes(region: Region, bounds: Box): number {
  const steps = 24;
  const normal = planeNormal(region.plane);
  const at = (axis: Axis, i: number) => bounds.low[axis] + ((i + 0.5) / steps) * (bounds.high[axis] - bounds.low[axis]);
  const within = (axis: Axis, value: number) => value >= region.low[axis] && value <= region.high[axis];
  let gone = 0;
  for (let i = 0; i < steps ** 3; ++i) {
    const p = vec3(at("x", i % steps), at("y", Math.floor(i / steps) % steps), at("z", Math.floor(i / steps ** 2)));
    const kept =
      within("x", p.x) &&
      within("y", p.y) &&
      within("z", p.z) &&
      !(region.plane.on && dot(normal, p) > region.plane.offset);
    gone += Number(!kept);
  }
  return gone / steps ** 3;
}
