import type { CameraPose } from "../input/camera";
import { add, cross, dot, length, normalize, scale, subtract, vec3, type Vec3 } from "../input/vec3";
import { degrees } from "../scene/numbers";
import type { CameraValue, Numbers, Region } from "./definition";
import { randomNumbers } from "./random";

const head = vec3(0, 0, 1);

/**
 * Returns a random view: the direction to the eye is uniform on the sphere around the target, at the distance of
 * `pose`. The head stays up, because touch has no gesture to roll the picture. Depends on the seed and purpose only.
 */
export function randomView(seed: number, purpose: string, pose: CameraPose): CameraPose {
  const random = randomNumbers(seed, `view/${purpose}`);
  const z = 2 * random() - 1;
  const azimuth = 2 * Math.PI * random();
  const across = Math.sqrt(Math.max(0, 1 - z * z));
  const back = vec3(across * Math.cos(azimuth), across * Math.sin(azimuth), z);
  const right = normalize(cross(head, back), vec3(1, 0, 0));
  const distance = length(subtract(pose.eye, pose.target));
  return { ...pose, eye: add(pose.target, scale(back, distance)), up: cross(back, right) };
}

/**
 * Returns by how many degrees a region misses facing the viewer: the angle at the camera's target between the
 * directions to the eye and to the region. 0 if the region is at the target, which has no direction.
 */
export function facingError(pose: CameraPose, region: Vec3): number {
  const toEye = subtract(pose.eye, pose.target);
  const toRegion = subtract(region, pose.target);
  const lengths = length(toEye) * length(toRegion);
  if (lengths < 1e-9) return 0;
  return degrees(Math.acos(Math.max(-1, Math.min(1, dot(toEye, toRegion) / lengths))));
}

export const numbersOf = ({ x, y, z }: Vec3): Numbers => [x, y, z];
export const vectorOf = ([x, y, z]: Numbers): Vec3 => vec3(x, y, z);

export const cameraValue = ({ eye, target, up }: CameraPose): CameraValue => ({
  eye: numbersOf(eye),
  target: numbersOf(target),
  up: numbersOf(up),
});

/** The least distance of a latency task's region from the camera's target, in mm. A nearer one has no direction. */
export const leastOffset = 1;

export const isOffTarget = (region: Region, target: Vec3): boolean =>
  length(subtract(vectorOf(region.centre), target)) > leastOffset;
