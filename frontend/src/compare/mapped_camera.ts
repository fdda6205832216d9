import { refitted, type CameraPose } from "../input/camera";
import { add, dot, length, scale, subtract, vec3, type Vec3 } from "../input/vec3";
import type { Viewport } from "../protocol/messages";

/** What a camera frames: the middle of the subject and half the height of the picture there, in mm. */
export interface Framing {
  readonly centre: Vec3;
  readonly size: number;
}

/** A rigid motion between the coordinates of two pictures: 16 numbers, row-major 4 x 4. */
export type Motion = readonly number[];

export const identity: Motion = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

const halfAngle = (pose: CameraPose): number => Math.tan((pose.verticalFovDegrees * Math.PI) / 360);

export const framingOf = (pose: CameraPose): Framing => ({
  centre: pose.target,
  size: length(subtract(pose.eye, pose.target)) * halfAngle(pose),
});

/**
 * Returns the camera that sees the other scan from the same side of the patient, and as large in
 * proportion to what `to` frames.
 */
export function relativePose(pose: CameraPose, from: Framing, to: Framing): CameraPose {
  const grown = from.size > 0 && to.size > 0 ? to.size / from.size : 1;
  const moved = (place: Vec3) => add(to.centre, scale(subtract(place, from.centre), grown));
  return { ...pose, eye: moved(pose.eye), target: moved(pose.target) };
}

const row = (motion: Motion, n: number): Vec3 =>
  vec3(motion[4 * n] ?? 0, motion[4 * n + 1] ?? 0, motion[4 * n + 2] ?? 0);
const rows = (motion: Motion): readonly [Vec3, Vec3, Vec3] => [row(motion, 0), row(motion, 1), row(motion, 2)];
const shiftOf = (motion: Motion): Vec3 => vec3(motion[3] ?? 0, motion[7] ?? 0, motion[11] ?? 0);

const turned = ([x, y, z]: readonly [Vec3, Vec3, Vec3], v: Vec3): Vec3 => vec3(dot(x, v), dot(y, v), dot(z, v));

export function movedPoint(motion: Motion, place: Vec3): Vec3 {
  return add(turned(rows(motion), place), shiftOf(motion));
}

/** Returns the camera that sees the same place, moved rigidly. */
export function movedPose(motion: Motion, pose: CameraPose): CameraPose {
  return {
    ...pose,
    eye: movedPoint(motion, pose.eye),
    target: movedPoint(motion, pose.target),
    up: turned(rows(motion), pose.up),
  };
}

/** Returns the inverse of a rigid motion. */
export function inverse(motion: Motion): Motion {
  const [x, y, z] = rows(motion);
  const columns = [vec3(x.x, y.x, z.x), vec3(x.y, y.y, z.y), vec3(x.z, y.z, z.z)] as const;
  const shift = turned(columns, scale(shiftOf(motion), -1));
  return [
    ...[columns[0].x, columns[0].y, columns[0].z, shift.x],
    ...[columns[1].x, columns[1].y, columns[1].z, shift.y],
    ...[columns[2].x, columns[2].y, columns[2].z, shift.z],
    ...[0, 0, 0, 1],
  ];
}

const aspect = ({ width, height }: Viewport): number => width / height;

/** Applies `map` to the camera as a square picture would have it, so that pictures of other shapes show as much. */
export function inSquare(
  pose: CameraPose,
  shapes: { readonly from: Viewport; readonly to: Viewport },
  map: (pose: CameraPose) => CameraPose,
): CameraPose {
  return refitted(map(refitted(pose, aspect(shapes.from), 1)), 1, aspect(shapes.to));
}
