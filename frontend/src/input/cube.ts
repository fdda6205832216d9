import { inPicture, orbitFrame, orbitOf, patientAxes, type CameraPose } from "./camera";
import { add, cross, length, scale, subtract, vec3, type Vec3 } from "./vec3";

/** One visible face of the orientation cube. y points down, and half the length of an edge is 1. */
export interface CubeFace {
  readonly letter: string;
  readonly corners: readonly { readonly x: number; readonly y: number }[];
  readonly middle: { readonly x: number; readonly y: number };
  /** 1 if the face is seen straight on, and close to 0 if it is seen edge-on. */
  readonly facing: number;
}

const otherAxis = (axis: Vec3): Vec3 => (Math.abs(axis.z) > 0.5 ? vec3(1, 0, 0) : vec3(0, 0, 1));

/** Returns the faces turned towards the viewer, the most slanted first. */
export function cubeFaces(pose: CameraPose): CubeFace[] {
  const frame = orbitFrame(orbitOf(pose));
  const onScreen = (point: Vec3) => {
    const p = inPicture(frame, point);
    return { x: p.x, y: -p.y };
  };
  return patientAxes
    .map(({ letter, axis }) => {
      const u = otherAxis(axis);
      const v = cross(axis, u);
      const corners = [
        [1, 1],
        [1, -1],
        [-1, -1],
        [-1, 1],
      ].map(([a = 0, b = 0]) => onScreen(add(axis, add(scale(u, a), scale(v, b)))));
      return { letter, corners, middle: onScreen(axis), facing: inPicture(frame, axis).z };
    })
    .filter((face) => face.facing > 0.02)
    .sort((a, b) => a.facing - b.facing);
}

/** The letters of the sides, in the order in which they are offered. */
export const standardSides = ["A", "P", "L", "R", "S", "I"] as const;

/**
 * Returns the camera that views the target from the side of a face, at the same distance and with
 * the head at the top. The views from above and below are those that a camera in front of the
 * patient reaches by rising or sinking.
 */
export function poseFromSide(pose: CameraPose, letter: string): CameraPose {
  const axis = patientAxes.find((one) => one.letter === letter)?.axis;
  if (!axis) return pose;
  const distance = length(subtract(pose.eye, pose.target));
  const up = vec3(0, axis.z, Math.abs(axis.z) > 0.5 ? 0 : 1);
  return { ...pose, eye: add(pose.target, scale(axis, distance)), up };
}
