import { create } from "@bufbuild/protobuf";
import type { Axis, Box } from "../picture/project";
import { dot, normalize, scale, vec3, type Vec3 } from "../input/vec3";
import {
  Clip_PlaneSchema,
  ClipSchema,
  Slices_Colouring,
  Slices_SliceSchema,
  SlicesSchema,
  Vec3Schema,
  type Clip,
  type Clip_Plane,
  type Scene,
  type Slices,
} from "../protocol/gen/api/proto/scene_pb";
import { direction_of, of_patient, seen_from_front, unit_of, type Direction } from "./direction";
import { clamp, replaced, within, without, type Limits } from "./numbers";

export type Side = "low" | "high";
export const axes: readonly Axis[] = ["x", "y", "z"];
export const most_planes = 6;
export const least_side_mm = 1;
export const window_width_limits: Limits = { low: 1, high: 100_000 };
export const window_centre_limits: Limits = { low: -100_000, high: 100_000 };

/** Who cuts wants to see what is inside, and without light it would be black. */
const clip_of = (scene: Scene): Clip => scene.clip ?? create(ClipSchema, { cutsLight: true });
const message = (v: Vec3) => create(Vec3Schema, v);
const vector = (v: { readonly x: number; readonly y: number; readonly z: number } | undefined): Vec3 => (v ? vec3(v.x, v.y, v.z) : vec3(0, 0, 0));

/** What is left of the volume's box, mm. */
export function box_of(scene: Scene, bounds: Box): Box {
  const { boxLow, boxHigh } = clip_of(scene);
  return boxLow && boxHigh ? { low: vector(boxLow), high: vector(boxHigh) } : bounds;
}

/** As far as it may go: not through the face opposite, nor out of the volume. */
export function face_limits(scene: Scene, bounds: Box, axis: Axis, side: Side): Limits {
  const box = box_of(scene, bounds);
  return side === "low"
    ? { low: bounds.low[axis], high: Math.max(bounds.low[axis], box.high[axis] - least_side_mm) }
    : { low: Math.min(bounds.high[axis], box.low[axis] + least_side_mm), high: bounds.high[axis] };
}

export function move_face(scene: Scene, bounds: Box, axis: Axis, side: Side, to: number): Scene {
  const box = box_of(scene, bounds);
  const value = within(to, face_limits(scene, bounds, axis, side), box[side][axis]);
  const moved = { ...box, [side]: { ...box[side], [axis]: value } };
  const whole = axes.every((one) => moved.low[one] <= bounds.low[one] && moved.high[one] >= bounds.high[one]);
  const { planes, cutsLight } = clip_of(scene);
  const corners = whole ? {} : { boxLow: message(moved.low), boxHigh: message(moved.high) };
  return { ...scene, clip: { ...create(ClipSchema), planes, cutsLight, ...corners } };
}

export const cuts_light = (scene: Scene): boolean => clip_of(scene).cutsLight;
export const set_cuts_light = (scene: Scene, cutsLight: boolean): Scene => ({ ...scene, clip: { ...clip_of(scene), cutsLight } });

/** A plane by the direction to which it cuts away, as seen from the patient's front, and how far from the middle. */
export interface Plane extends Direction {
  /** mm. */
  readonly offset: number;
}

export const planes_of = (scene: Scene): readonly Plane[] => clip_of(scene).planes.map(plane_of);

function plane_of(plane: Clip_Plane): Plane {
  const normal = normalize(vector(plane.normal), vec3(0, -1, 0));
  return { ...direction_of(seen_from_front(normal)), offset: dot(normal, vector(plane.point)) };
}

function message_of(plane: Plane): Clip_Plane {
  const normal = normal_of(plane);
  return create(Clip_PlaneSchema, { normal: message(normal), point: message(scale(normal, plane.offset)) });
}

/** Unit, to the side that is cut away. */
export const normal_of = (plane: Direction): Vec3 => of_patient(unit_of(plane));

/** Half of the box's diagonal: beyond it a plane cuts nothing, or all. */
export const reach_of = ({ low, high }: Box): number => Math.hypot(high.x - low.x, high.y - low.y, high.z - low.z) / 2;

export const add_plane = (scene: Scene): Scene => {
  const clip = clip_of(scene);
  return clip.planes.length >= most_planes ? scene : { ...scene, clip: { ...clip, planes: [...clip.planes, message_of({ right: 0, up: 0, offset: 0 })] } };
};

export function move_plane(scene: Scene, bounds: Box, index: number, to: Partial<Plane>): Scene {
  const clip = clip_of(scene);
  const old = clip.planes[index];
  if (!old) return scene;
  const before = plane_of(old);
  const reach = reach_of(bounds);
  const plane: Plane = {
    right: within(to.right ?? before.right, { low: -180, high: 180 }, before.right),
    up: within(to.up ?? before.up, { low: -90, high: 90 }, before.up),
    offset: within(to.offset ?? before.offset, { low: -reach, high: reach }, before.offset),
  };
  return { ...scene, clip: { ...clip, planes: replaced(clip.planes, index, message_of(plane)) } };
}

/** To another normal, about a place that it passes through. */
export function turn_plane(scene: Scene, bounds: Box, index: number, normal: Vec3, through: Vec3): Scene {
  const old = planes_of(scene)[index];
  const way = direction_of(seen_from_front(normal), old?.right);
  return move_plane(scene, bounds, index, { ...way, offset: dot(normal_of(way), through) });
}

export const remove_plane = (scene: Scene, index: number): Scene => {
  const clip = clip_of(scene);
  return { ...scene, clip: { ...clip, planes: without(clip.planes, index) } };
};

export type SliceName = "sagittal" | "coronal" | "axial";
export const slice_axes: Readonly<Record<SliceName, Axis>> = { sagittal: "x", coronal: "y", axial: "z" };
export const slice_names: readonly SliceName[] = ["axial", "coronal", "sagittal"];

/** What the scan says of its grey, else a soft-tissue window. */
export interface Grey {
  readonly centre: number;
  readonly width: number;
}

export const slices_of = (scene: Scene): Slices => scene.slices ?? create(SlicesSchema);

/** Grey needs a window: without one a scene with a slice is refused. */
function windowed(slices: Slices, grey: Grey): Slices {
  if (slices.windowWidth >= window_width_limits.low) return slices;
  const width = grey.width > 0 ? clamp(grey.width, window_width_limits.low, window_width_limits.high) : 400;
  return { ...slices, windowCentre: grey.width > 0 ? grey.centre : 40, windowWidth: width };
}

/** Alone without any slice would be an empty picture. */
function not_empty(slices: Slices): Slices {
  return slices.alone && !slice_names.some((name) => slices[name]?.shown) ? { ...slices, alone: false } : slices;
}

const with_slices = (scene: Scene, slices: Slices, grey: Grey): Scene => ({ ...scene, slices: not_empty(windowed(slices, grey)) });

export function set_slice(scene: Scene, bounds: Box, grey: Grey, name: SliceName, to: { readonly shown?: boolean; readonly position?: number }): Scene {
  const slices = slices_of(scene);
  const old = slices[name] ?? create(Slices_SliceSchema);
  const axis = slice_axes[name];
  const position = within(to.position ?? old.position, { low: bounds.low[axis], high: bounds.high[axis] }, old.position);
  return with_slices(scene, { ...slices, [name]: { ...old, shown: to.shown ?? old.shown, position } }, grey);
}

export const set_alone = (scene: Scene, grey: Grey, alone: boolean): Scene => with_slices(scene, { ...slices_of(scene), alone }, grey);

export const set_colouring = (scene: Scene, grey: Grey, transfer: boolean): Scene =>
  with_slices(scene, { ...slices_of(scene), colouring: transfer ? Slices_Colouring.TRANSFER : Slices_Colouring.GREY }, grey);

export function set_window(scene: Scene, grey: Grey, to: { readonly centre?: number; readonly width?: number }): Scene {
  const slices = windowed(slices_of(scene), grey);
  const windowCentre = within(to.centre ?? slices.windowCentre, window_centre_limits, slices.windowCentre);
  const windowWidth = within(to.width ?? slices.windowWidth, window_width_limits, slices.windowWidth);
  return with_slices(scene, { ...slices, windowCentre, windowWidth }, grey);
}
