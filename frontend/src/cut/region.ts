import { orbit_frame, orbit_of, type CameraPose } from "../input/camera";
import { add, cross, dot, length, scale, subtract, vec3, type Vec3 } from "../input/vec3";

/** Where a plane's normal points, from straight ahead, and where the plane is. */
export interface FacePlane {
  readonly on: boolean;
  /** Degrees: 0 cuts the front off upright, 90 the bottom off level. */
  readonly tilt: number;
  /** Degrees to the patient's left, for a head that looks aside. */
  readonly aside: number;
  /** mm from the middle of the scan, along the normal. */
  readonly offset: number;
}

/** What is kept: a box along the patient's axes, and of it what lies behind the plane. mm in world space. */
export interface Region {
  readonly low: Vec3;
  readonly high: Vec3;
  readonly plane: FacePlane;
}

export interface Box {
  readonly low: Vec3;
  readonly high: Vec3;
}

export const least_side_mm = 10;

/** The smallest box along the patient's axes around a volume. `direction` row by row, its columns the voxels' axes. */
export function bounds_of(volume: { readonly size: readonly number[]; readonly spacing: readonly number[]; readonly direction: readonly number[] }): Box {
  const half = [0, 1, 2].map((p) =>
    [0, 1, 2].reduce((sum, v) => sum + (Math.abs(volume.direction[3 * p + v] ?? 0) * (volume.spacing[v] ?? 1) * (volume.size[v] ?? 0)) / 2, 0));
  const [x = 0, y = 0, z = 0] = half;
  return { low: vec3(-x, -y, -z), high: vec3(x, y, z) };
}

export function plane_normal(plane: FacePlane): Vec3 {
  const down = radians(plane.tilt), aside = radians(plane.aside);
  return vec3(Math.cos(down) * Math.sin(aside), -Math.cos(down) * Math.cos(aside), -Math.sin(down));
}

const radians = (degrees: number): number => (degrees * Math.PI) / 180;
const degrees = (angle: number): number => (angle * 180) / Math.PI;

const clamp = (value: number, low: number, high: number): number => Math.min(high, Math.max(low, value));

/** All of it, and a plane that is off but ready: in front of and below the middle. */
export function whole(bounds: Box): Region {
  const reach = bounds.high.y;
  return { low: bounds.low, high: bounds.high, plane: { on: false, tilt: 50, aside: 0, offset: reach * 0.5 } };
}

/** How the server says a region. */
export interface RegionBody {
  readonly box: { readonly low: readonly number[]; readonly high: readonly number[] };
  readonly planes?: readonly { readonly point: readonly number[]; readonly normal: readonly number[] }[];
}

const vector = ([x = 0, y = 0, z = 0]: readonly number[]): Vec3 => vec3(x, y, z);
const numbers = (v: Vec3): [number, number, number] => [v.x, v.y, v.z];

export function from_proposal(proposal: RegionBody, bounds: Box): Region {
  const start = whole(bounds);
  const first = proposal.planes?.[0];
  if (!first) return start;
  const normal = vector(first.normal);
  const tilt = degrees(Math.atan2(-normal.z, Math.hypot(normal.x, normal.y)));
  const plane = { on: true, tilt, aside: degrees(Math.atan2(normal.x, -normal.y)), offset: 0 };
  return { ...start, plane: { ...plane, offset: dot(plane_normal(plane), vector(first.point)) } };
}

export function to_body(region: Region): RegionBody {
  const normal = plane_normal(region.plane);
  const planes = region.plane.on ? [{ point: numbers(scale(normal, region.plane.offset)), normal: numbers(normal) }] : [];
  return { box: { low: numbers(region.low), high: numbers(region.high) }, planes };
}

export type Axis = "x" | "y" | "z";
export type Handle = { readonly kind: "face"; readonly axis: Axis; readonly side: "low" | "high" } | { readonly kind: "plane" };

export const handles: readonly Handle[] = [
  ...(["x", "y", "z"] as const).flatMap((axis) => (["low", "high"] as const).map((side) => ({ kind: "face" as const, axis, side }))),
  { kind: "plane" },
];

/** Where along its way a handle stands, mm, and how far it may go. */
export function range_of(handle: Handle, region: Region, bounds: Box): { readonly at: number; readonly low: number; readonly high: number } {
  if (handle.kind === "plane") {
    const normal = plane_normal(region.plane);
    const reach = Math.abs(normal.x) * bounds.high.x + Math.abs(normal.y) * bounds.high.y + Math.abs(normal.z) * bounds.high.z;
    return { at: region.plane.offset, low: -reach, high: reach };
  }
  const { axis, side } = handle;
  return side === "low"
    ? { at: region.low[axis], low: bounds.low[axis], high: region.high[axis] - least_side_mm }
    : { at: region.high[axis], low: region.low[axis] + least_side_mm, high: bounds.high[axis] };
}

export function moved(handle: Handle, to: number, region: Region, bounds: Box): Region {
  const { low, high } = range_of(handle, region, bounds);
  const at = clamp(to, low, Math.max(low, high));
  if (handle.kind === "plane") return { ...region, plane: { ...region.plane, offset: at } };
  return { ...region, [handle.side]: { ...region[handle.side], [handle.axis]: at } };
}

export function corners(box: Box): Vec3[] {
  const of = (i: number, bit: number, axis: Axis) => (i & bit ? box.high[axis] : box.low[axis]);
  return [0, 1, 2, 3, 4, 5, 6, 7].map((i) => vec3(of(i, 1, "x"), of(i, 2, "y"), of(i, 4, "z")));
}

/** Pairs of corners. */
export const edges: readonly (readonly [number, number])[] = [
  [0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7],
];

/** Where the plane meets the box: a polygon, its corners in order around; nothing when it passes by. */
export function plane_in_box(region: Region): Vec3[] {
  if (!region.plane.on) return [];
  const normal = plane_normal(region.plane);
  const points = corners(region);
  const crossing: Vec3[] = [];
  for (const [a, b] of edges) {
    const from = points[a], to = points[b];
    if (!from || !to) continue;
    const before = dot(normal, from) - region.plane.offset, behind = dot(normal, to) - region.plane.offset;
    if (before * behind < 0) crossing.push(add(from, scale(subtract(to, from), before / (before - behind))));
  }
  const middle = middle_of(crossing);
  if (!middle) return [];
  // Around it by the level direction that it holds and the one across.
  const aside = radians(region.plane.aside);
  const level = vec3(Math.cos(aside), Math.sin(aside), 0);
  const across = cross(normal, level);
  const angle = (p: Vec3) => Math.atan2(dot(subtract(p, middle), across), dot(subtract(p, middle), level));
  return crossing.sort((p, q) => angle(p) - angle(q));
}

export function middle_of(points: readonly Vec3[]): Vec3 | null {
  return points.length === 0 ? null : scale(points.reduce(add), 1 / points.length);
}

/** Where a handle is, and the direction in which it goes. */
export function place_of(handle: Handle, region: Region): { readonly place: Vec3; readonly along: Vec3 } | null {
  if (handle.kind === "plane") {
    const place = middle_of(plane_in_box(region));
    return place && { place, along: plane_normal(region.plane) };
  }
  const middle = scale(add(region.low, region.high), 0.5);
  const along = vec3(Number(handle.axis === "x"), Number(handle.axis === "y"), Number(handle.axis === "z"));
  return { place: { ...middle, [handle.axis]: region[handle.side][handle.axis] }, along };
}

export interface Screen {
  readonly width: number;
  readonly height: number;
}

/** In pixels of the picture from its upper left; nothing for what lies behind the eye. */
export function on_screen(pose: CameraPose, screen: Screen, place: Vec3): { readonly x: number; readonly y: number } | null {
  const orbit = orbit_of(pose);
  const frame = orbit_frame(orbit);
  const from_eye = subtract(place, pose.eye);
  const ahead = -dot(from_eye, frame.back);
  if (ahead < 1) return null;
  const pixels = screen.height / 2 / Math.tan((pose.verticalFovDegrees * Math.PI) / 360) / ahead;
  return { x: screen.width / 2 + dot(from_eye, frame.right) * pixels, y: screen.height / 2 - dot(from_eye, frame.up) * pixels };
}

/**
 * How many mm along `along` a hand means that moves by so many pixels. Nothing when the way points at the viewer, so that
 * a pixel would be too far to be meant.
 */
export function dragged(pose: CameraPose, screen: Screen, place: Vec3, along: Vec3, by: { readonly x: number; readonly y: number }): number | null {
  const here = on_screen(pose, screen, place), ahead = on_screen(pose, screen, add(place, along));
  if (!here || !ahead) return null;
  const x = ahead.x - here.x, y = ahead.y - here.y;
  const square = x * x + y * y;
  return square < 0.04 ? null : (by.x * x + by.y * y) / square;
}

/** Pixels: the side of a handle's target (style/cut.css). */
export const handle_px = 44;

export interface PlacedHandle {
  readonly handle: Handle;
  readonly place: Vec3;
  readonly along: Vec3;
  readonly x: number;
  readonly y: number;
}

/**
 * The handles that a hand can take, each where it is on the screen. Of two that would lie on each other the one that is held
 * stays, then the plane's, then the nearer one: the other would be hit by chance. The sliders are the way to it meanwhile.
 */
export function handles_to_take(pose: CameraPose, screen: Screen, region: Region, held: Handle | null): PlacedHandle[] {
  const placed = handles.flatMap((handle) => {
    const where = place_of(handle, region);
    const point = where && on_screen(pose, screen, where.place);
    return point ? [{ handle, ...where, ...point }] : [];
  });
  const rank = ({ handle, place }: PlacedHandle) => (handle === held ? -2 : handle.kind === "plane" ? -1 : length(subtract(place, pose.eye)));
  const taken: PlacedHandle[] = [];
  for (const one of [...placed].sort((a, b) => rank(a) - rank(b))) {
    if (taken.every(({ x, y }) => Math.hypot(x - one.x, y - one.y) >= handle_px)) taken.push(one);
  }
  return placed.filter((one) => taken.includes(one));
}

/** The part of the scan that goes, 0 to 1, by a lattice of places: for a person to read, not to rely on. */
export function part_that_goes(region: Region, bounds: Box): number {
  const steps = 24;
  const normal = plane_normal(region.plane);
  const at = (axis: Axis, i: number) => bounds.low[axis] + ((i + 0.5) / steps) * (bounds.high[axis] - bounds.low[axis]);
  const within = (axis: Axis, value: number) => value >= region.low[axis] && value <= region.high[axis];
  let gone = 0;
  for (let i = 0; i < steps ** 3; ++i) {
    const p = vec3(at("x", i % steps), at("y", Math.floor(i / steps) % steps), at("z", Math.floor(i / steps ** 2)));
    const kept = within("x", p.x) && within("y", p.y) && within("z", p.z) && !(region.plane.on && dot(normal, p) > region.plane.offset);
    gone += Number(!kept);
  }
  return gone / steps ** 3;
}
