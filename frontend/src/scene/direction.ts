import { orbitFrame, orbitOf, type CameraPose } from "../input/camera";
import { add, cross, dot, length, normalize, scale, subtract, vec3, type Vec3 } from "../input/vec3";
import { clamp, degrees, radians } from "./numbers";

/**
 * A direction as seen from the middle, in degrees. (0, 0) points to the front, `right` reaches 180 on either side, and
 * `up` reaches 90.
 */
export interface Direction {
  readonly right: number;
  readonly up: number;
}

/** Returns the unit vector of a direction: x points to the right, y up, and z to the viewer. */
export function unitOf({ right, up }: Direction): Vec3 {
  const r = radians(right),
    u = radians(up);
  return vec3(Math.sin(r) * Math.cos(u), Math.sin(u), Math.cos(r) * Math.cos(u));
}

/**
 * Returns the direction of a point. Straight above or below, `right` is undefined and becomes
 * `otherwise`.
 */
export function directionOf(place: Vec3, otherwise = 0): Direction {
  const n = normalize(place, vec3(0, 0, 1));
  const upright = Math.hypot(n.x, n.z) < 1e-9;
  return { right: upright ? otherwise : degrees(Math.atan2(n.x, n.z)), up: degrees(Math.asin(clamp(n.y, -1, 1))) };
}

/** Converts between the patient's axes and those of a viewer in front of the patient. */
export const seenFromFront = ({ x, y, z }: Vec3): Vec3 => vec3(x, z, -y);
export const ofPatient = ({ x, y, z }: Vec3): Vec3 => vec3(x, -z, y);

/**
 * Converts between the camera's frame (origin at the target) and the world. With `free`, converts directions instead of
 * positions.
 */
export function toWorld(pose: CameraPose, v: Vec3, free = false): Vec3 {
  const frame = orbitFrame(orbitOf(pose));
  const turned = add(add(scale(frame.right, v.x), scale(frame.up, v.y)), scale(frame.back, v.z));
  return free ? turned : add(turned, pose.target);
}

export function fromWorld(pose: CameraPose, v: Vec3, free = false): Vec3 {
  const frame = orbitFrame(orbitOf(pose));
  const p = free ? v : subtract(v, pose.target);
  return vec3(dot(p, frame.right), dot(p, frame.up), dot(p, frame.back));
}

/**
 * Returns two unit vectors perpendicular to `normal`. The first is level with regard to `up`, and cross(first, second)
 * is `normal`.
 */
export function across(normal: Vec3, up: Vec3): readonly [Vec3, Vec3] {
  const level = cross(up, normal);
  const u =
    length(level) > 1e-6
      ? normalize(level, vec3(1, 0, 0))
      : normalize(cross(vec3(up.y, up.z, up.x), normal), vec3(1, 0, 0));
  return [u, cross(normal, u)];
}

/**
 * Returns the direction at a point of a drawn ball of radius 1, with x to the right and y down. Beyond the rim, it
 * continues on the back.
 */
export function directionOnBall(
  x: number,
  y: number,
  behind: boolean,
): { readonly direction: Direction; readonly behind: boolean } {
  const r = Math.hypot(x, y);
  const over = r > 1;
  const near = over ? Math.max(0, 2 - r) : r;
  const s = r > 1e-9 ? near / r : 0;
  const back = over ? !behind : behind;
  const depth = Math.sqrt(Math.max(0, 1 - near * near)) * (back ? -1 : 1);
  return { direction: directionOf(vec3(x * s, -y * s, depth)), behind };
}
