import { add, cross, dot, length, normalize, scale, subtract, vec3, type Vec3 } from "./vec3";

/** A camera in the terms of the protocol. `eye` and `target` are in millimetres. */
export interface CameraPose {
  readonly eye: Vec3;
  readonly target: Vec3;
  readonly up: Vec3;
  /** In degrees, between 0 and 180 exclusive. */
  readonly verticalFovDegrees: number;
}

/**
 * A camera as a turntable about its target, the form in which users move it. Angles are in radians. The azimuth turns
 * about the head-foot axis, and the elevation is above the horizon. A positive roll leans the camera to its right, so
 * the picture turns counter-clockwise.
 */
export interface Orbit {
  readonly target: Vec3;
  readonly distance: number;
  readonly azimuth: number;
  readonly elevation: number;
  readonly roll: number;
  readonly verticalFovDegrees: number;
}

/** The right, up and backward (towards the eye) vectors of a camera: a right-handed orthonormal frame. */
export interface CameraFrame {
  readonly right: Vec3;
  readonly up: Vec3;
  readonly back: Vec3;
}

const pole = vec3(0, 0, 1);
/** The steepest elevation at which "up" is still defined, so that the horizon never flips during a drag. */
const steepest = (89.5 * Math.PI) / 180;

export const closestMm = 5;
export const farthestMm = 20_000;

const clamp = (value: number, low: number, high: number): number => Math.min(high, Math.max(low, value));

function unrolled(azimuth: number, elevation: number): CameraFrame {
  const back = vec3(
    Math.cos(elevation) * Math.cos(azimuth),
    Math.cos(elevation) * Math.sin(azimuth),
    Math.sin(elevation),
  );
  // `right` is not cross(pole, back), because this form stays exact when looking straight down.
  const right = vec3(-Math.sin(azimuth), Math.cos(azimuth), 0);
  return { right, up: cross(back, right), back };
}

export function orbitFrame(orbit: Orbit): CameraFrame {
  const plain = unrolled(orbit.azimuth, orbit.elevation);
  const c = Math.cos(orbit.roll);
  const s = Math.sin(orbit.roll);
  return {
    right: subtract(scale(plain.right, c), scale(plain.up, s)),
    up: add(scale(plain.up, c), scale(plain.right, s)),
    back: plain.back,
  };
}

/**
 * Returns a camera as a turntable. Precondition: `eye` differs from `target`. An `up` parallel to
 * the view direction counts as no roll.
 */
export function orbitOf(pose: CameraPose): Orbit {
  const away = subtract(pose.eye, pose.target);
  const distance = length(away);
  const back = normalize(away, vec3(0, -1, 0));
  const elevation = Math.asin(clamp(back.z, -1, 1));
  const overhead = Math.hypot(back.x, back.y) < 1e-6;
  // From straight above or below, the azimuth is the direction opposite to the top of the picture.
  const azimuth = overhead ? Math.atan2(-pose.up.y * back.z, -pose.up.x * back.z) : Math.atan2(back.y, back.x);
  const plain = unrolled(azimuth, elevation);
  const roll = overhead ? 0 : Math.atan2(dot(pose.up, plain.right), dot(pose.up, plain.up));
  return {
    target: pose.target,
    distance: clamp(distance, closestMm, farthestMm),
    azimuth,
    elevation: clamp(elevation, -steepest, steepest),
    roll,
    verticalFovDegrees: pose.verticalFovDegrees,
  };
}

export function poseOf(orbit: Orbit): CameraPose {
  const frame = orbitFrame(orbit);
  return {
    eye: add(orbit.target, scale(frame.back, orbit.distance)),
    target: orbit.target,
    up: frame.up,
    verticalFovDegrees: orbit.verticalFovDegrees,
  };
}

/**
 * Rotates the object like a hand on its near side: what is dragged to the right moves to the right. `right` and `down`
 * are in radians as seen in the picture, independent of the roll.
 */
export function rotated(orbit: Orbit, right: number, down: number): Orbit {
  const c = Math.cos(orbit.roll);
  const s = Math.sin(orbit.roll);
  return {
    ...orbit,
    azimuth: wrapped(orbit.azimuth - (right * c - down * s)),
    elevation: clamp(orbit.elevation + (down * c + right * s), -steepest, steepest),
  };
}

/** Rotates the picture clockwise by `angle` radians. */
export function rolled(orbit: Orbit, angle: number): Orbit {
  return { ...orbit, roll: wrapped(orbit.roll - angle) };
}

/** Scales the object in the picture by `factor` by moving the eye. */
export function zoomed(orbit: Orbit, factor: number): Orbit {
  if (!(factor > 0) || !Number.isFinite(factor)) return orbit;
  return { ...orbit, distance: clamp(orbit.distance / factor, closestMm, farthestMm) };
}

/** Moves the picture to the right and down by fractions of its height, so that the target follows the pointer. */
export function panned(orbit: Orbit, right: number, down: number): Orbit {
  const frame = orbitFrame(orbit);
  const height = 2 * orbit.distance * Math.tan((orbit.verticalFovDegrees * Math.PI) / 360);
  const shift = add(scale(frame.right, -right * height), scale(frame.up, down * height));
  return { ...orbit, target: add(orbit.target, shift) };
}

/**
 * Moves the eye for a picture of another aspect ratio, so that the shorter side of the picture
 * shows as much as before.
 */
export function refitted(pose: CameraPose, aspectBefore: number, aspect: number): CameraPose {
  if (!(aspectBefore > 0) || !(aspect > 0)) return pose;
  const factor = Math.max(1, 1 / aspect) / Math.max(1, 1 / aspectBefore);
  if (factor === 1) return pose;
  return { ...pose, eye: add(pose.target, scale(subtract(pose.eye, pose.target), factor)) };
}

/** Whether two cameras are the same except for rounding, as after a change of the window's shape. */
export function isSamePose(a: CameraPose, b: CameraPose): boolean {
  const rounding = 1e-6;
  const far = rounding * length(subtract(b.eye, b.target));
  return (
    length(subtract(a.eye, b.eye)) <= far &&
    length(subtract(a.target, b.target)) <= far &&
    length(subtract(a.up, b.up)) <= rounding &&
    Math.abs(a.verticalFovDegrees - b.verticalFovDegrees) <= rounding
  );
}

/**
 * Returns where a unit axis of the patient points in the picture: x to the right, y up, z towards
 * the viewer.
 */
export function inPicture(frame: CameraFrame, axis: Vec3): Vec3 {
  return vec3(dot(axis, frame.right), dot(axis, frame.up), dot(axis, frame.back));
}

export const patientAxes: readonly { readonly letter: string; readonly axis: Vec3 }[] = [
  { letter: "L", axis: vec3(1, 0, 0) },
  { letter: "R", axis: vec3(-1, 0, 0) },
  { letter: "P", axis: vec3(0, 1, 0) },
  { letter: "A", axis: vec3(0, -1, 0) },
  { letter: "S", axis: pole },
  { letter: "I", axis: vec3(0, 0, -1) },
];

function wrapped(angle: number): number {
  const turn = 2 * Math.PI;
  return angle - turn * Math.round(angle / turn);
}
