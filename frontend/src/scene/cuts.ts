import { create } from "@bufbuild/protobuf";
import type { Axis, Box } from "../picture/project";
import { dot, normalize, scale, vec3, type Vec3 } from "../input/vec3";
import {
  Clip_PlaneSchema as ClipPlaneSchema,
  ClipSchema,
  Slices_Colouring as SlicesColouring,
  Slices_SliceSchema as SlicesSliceSchema,
  SlicesSchema,
  Vec3Schema,
  type Clip,
  type Clip_Plane as ClipPlane,
  type Scene,
  type Slices,
} from "../protocol/gen/api/proto/scene_pb";
import { directionOf, ofPatient, seenFromFront, unitOf, type Direction } from "./direction";
import { clamp, replaced, within, without, type Limits } from "./numbers";

export type Side = "low" | "high";
export const axes: readonly Axis[] = ["x", "y", "z"];
export const mostPlanes = 6;
export const leastSideMm = 1;
export const windowWidthLimits: Limits = { low: 1, high: 100_000 };
export const windowCentreLimits: Limits = { low: -100_000, high: 100_000 };

/**
 * Returns the clip of the scene. By default, light passes through the parts that are cut away, or
 * the inside would be black.
 */
const clipOf = (scene: Scene): Clip => scene.clip ?? create(ClipSchema, { cutsLight: true });
const message = (v: Vec3) => create(Vec3Schema, v);
const vector = (v: { readonly x: number; readonly y: number; readonly z: number } | undefined): Vec3 =>
  v ? vec3(v.x, v.y, v.z) : vec3(0, 0, 0);

/** Returns what remains of the volume's box, in mm. */
export function boxOf(scene: Scene, bounds: Box): Box {
  const { boxLow, boxHigh } = clipOf(scene);
  return boxLow && boxHigh ? { low: vector(boxLow), high: vector(boxHigh) } : bounds;
}

/** Returns the limits of a face, which must not pass the opposite face or leave the volume. */
export function faceLimits(scene: Scene, bounds: Box, axis: Axis, side: Side): Limits {
  const box = boxOf(scene, bounds);
  return side === "low"
    ? { low: bounds.low[axis], high: Math.max(bounds.low[axis], box.high[axis] - leastSideMm) }
    : { low: Math.min(bounds.high[axis], box.low[axis] + leastSideMm), high: bounds.high[axis] };
}

export function moveFace(scene: Scene, bounds: Box, axis: Axis, side: Side, to: number): Scene {
  const box = boxOf(scene, bounds);
  const value = within(to, faceLimits(scene, bounds, axis, side), box[side][axis]);
  const moved = { ...box, [side]: { ...box[side], [axis]: value } };
  const isWholeBox = axes.every((one) => moved.low[one] <= bounds.low[one] && moved.high[one] >= bounds.high[one]);
  const { planes, cutsLight } = clipOf(scene);
  const corners = isWholeBox ? {} : { boxLow: message(moved.low), boxHigh: message(moved.high) };
  return { ...scene, clip: { ...create(ClipSchema), planes, cutsLight, ...corners } };
}

export const cutsLight = (scene: Scene): boolean => clipOf(scene).cutsLight;
export const setCutsLight = (scene: Scene, cutsLight: boolean): Scene => ({
  ...scene,
  clip: { ...clipOf(scene), cutsLight },
});

/** Whether the table, headrest or frame and the noise of the air are shown. */
export const showsTable = (scene: Scene): boolean => scene.showTable;
export const setShowsTable = (scene: Scene, showTable: boolean): Scene => ({ ...scene, showTable });

/**
 * A cutting plane: the direction of the side that it cuts away, as seen from in front of the patient, and its distance
 * from the middle.
 */
export interface Plane extends Direction {
  /** Distance from the middle in mm. */
  readonly offset: number;
}

export const planesOf = (scene: Scene): readonly Plane[] => clipOf(scene).planes.map(planeOf);

function planeOf(plane: ClipPlane): Plane {
  const normal = normalize(vector(plane.normal), vec3(0, -1, 0));
  return { ...directionOf(seenFromFront(normal)), offset: dot(normal, vector(plane.point)) };
}

function messageOf(plane: Plane): ClipPlane {
  const normal = normalOf(plane);
  return create(ClipPlaneSchema, { normal: message(normal), point: message(scale(normal, plane.offset)) });
}

/** Returns the unit normal, which points to the side that is cut away. */
export const normalOf = (plane: Direction): Vec3 => ofPatient(unitOf(plane));

/**
 * Returns half of the box's diagonal. A plane at a greater distance cuts away nothing or
 * everything.
 */
export const reachOf = ({ low, high }: Box): number => Math.hypot(high.x - low.x, high.y - low.y, high.z - low.z) / 2;

export const addPlane = (scene: Scene): Scene => {
  const clip = clipOf(scene);
  return clip.planes.length >= mostPlanes
    ? scene
    : { ...scene, clip: { ...clip, planes: [...clip.planes, messageOf({ right: 0, up: 0, offset: 0 })] } };
};

export function movePlane(scene: Scene, bounds: Box, index: number, to: Partial<Plane>): Scene {
  const clip = clipOf(scene);
  const old = clip.planes[index];
  if (!old) return scene;
  const before = planeOf(old);
  const reach = reachOf(bounds);
  const plane: Plane = {
    right: within(to.right ?? before.right, { low: -180, high: 180 }, before.right),
    up: within(to.up ?? before.up, { low: -90, high: 90 }, before.up),
    offset: within(to.offset ?? before.offset, { low: -reach, high: reach }, before.offset),
  };
  return { ...scene, clip: { ...clip, planes: replaced(clip.planes, index, messageOf(plane)) } };
}

/** Gives a plane another normal and keeps the point `through` on it. */
export function turnPlane(scene: Scene, bounds: Box, index: number, normal: Vec3, through: Vec3): Scene {
  const old = planesOf(scene)[index];
  const planeDirection = directionOf(seenFromFront(normal), old?.right);
  return movePlane(scene, bounds, index, { ...planeDirection, offset: dot(normalOf(planeDirection), through) });
}

export const removePlane = (scene: Scene, index: number): Scene => {
  const clip = clipOf(scene);
  return { ...scene, clip: { ...clip, planes: without(clip.planes, index) } };
};

export type SliceName = "sagittal" | "coronal" | "axial";
export const sliceAxes: Readonly<Record<SliceName, Axis>> = { sagittal: "x", coronal: "y", axial: "z" };
export const sliceNames: readonly SliceName[] = ["axial", "coronal", "sagittal"];

/** The grey window stored in the scan. Its width is 0 if there is none. */
export interface Grey {
  readonly centre: number;
  readonly width: number;
}

export const slicesOf = (scene: Scene): Slices => scene.slices ?? create(SlicesSchema);

export const showsSlices = (slices: Slices): boolean => sliceNames.some((name) => slices[name]?.shown);

/**
 * Adds a window, by default one for soft tissue, because the server refuses a scene with slices
 * without one.
 */
function windowed(slices: Slices, grey: Grey): Slices {
  if (slices.windowWidth >= windowWidthLimits.low) return slices;
  const width = grey.width > 0 ? clamp(grey.width, windowWidthLimits.low, windowWidthLimits.high) : 400;
  return { ...slices, windowCentre: grey.width > 0 ? grey.centre : 40, windowWidth: width };
}

/** Turns off showing only the slices if there are none, because the picture would be empty. */
function notEmpty(slices: Slices): Slices {
  return slices.alone && !showsSlices(slices) ? { ...slices, alone: false } : slices;
}

const withSlices = (scene: Scene, slices: Slices, grey: Grey): Scene => ({
  ...scene,
  slices: notEmpty(windowed(slices, grey)),
});

export function setSlice(
  scene: Scene,
  bounds: Box,
  grey: Grey,
  name: SliceName,
  to: { readonly shown?: boolean; readonly position?: number },
): Scene {
  const slices = slicesOf(scene);
  const old = slices[name] ?? create(SlicesSliceSchema);
  const axis = sliceAxes[name];
  const position = within(
    to.position ?? old.position,
    { low: bounds.low[axis], high: bounds.high[axis] },
    old.position,
  );
  return withSlices(scene, { ...slices, [name]: { ...old, shown: to.shown ?? old.shown, position } }, grey);
}

export const setAlone = (scene: Scene, grey: Grey, alone: boolean): Scene =>
  withSlices(scene, { ...slicesOf(scene), alone }, grey);

export const setColouring = (scene: Scene, grey: Grey, transfer: boolean): Scene =>
  withSlices(
    scene,
    { ...slicesOf(scene), colouring: transfer ? SlicesColouring.TRANSFER : SlicesColouring.GREY },
    grey,
  );

export function setWindow(scene: Scene, grey: Grey, to: { readonly centre?: number; readonly width?: number }): Scene {
  const slices = windowed(slicesOf(scene), grey);
  const windowCentre = within(to.centre ?? slices.windowCentre, windowCentreLimits, slices.windowCentre);
  const windowWidth = within(to.width ?? slices.windowWidth, windowWidthLimits, slices.windowWidth);
  return withSlices(scene, { ...slices, windowCentre, windowWidth }, grey);
}
