import { orbitFrame, orbitOf, poseOf, refitted, type CameraFrame, type CameraPose, type Orbit } from "./camera";
import { effort, pathOf, sampleDegrees, type CameraPath } from "./camera_path";
import { add, cross, dot, length, normalize, scale, subtract, vec3, type Vec3 } from "./vec3";

type Numbers = readonly [number, number, number];

/** A view that people chose: places in mm, and the direction to the top of the picture. */
export interface TourView {
  readonly eye: Numbers;
  readonly target: Numbers;
  readonly up: Numbers;
}

const toVec3 = ([x, y, z]: Numbers): Vec3 => vec3(x, y, z);

/** Returns a vector turned about a unit axis (Rodrigues). */
function turnedAbout(v: Vec3, axis: Vec3, angle: number): Vec3 {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return add(add(scale(v, c), scale(cross(axis, v), s)), scale(axis, dot(axis, v) * (1 - c)));
}

/** Returns the rotation from one frame to the other, about one axis. */
function rotationBetween(from: CameraFrame, to: CameraFrame): { readonly axis: Vec3; readonly angle: number } {
  const pairs = [[from.right, to.right] as const, [from.up, to.up] as const, [from.back, to.back] as const];
  const twiceSine = pairs.reduce((sum, [a, b]) => add(sum, cross(a, b)), vec3(0, 0, 0));
  const twiceCosine = pairs.reduce((sum, [a, b]) => sum + dot(a, b), 0) - 1;
  const angle = Math.atan2(length(twiceSine), twiceCosine);
  if (length(twiceSine) > 1e-6) return { axis: normalize(twiceSine, vec3(0, 0, 1)), angle };
  // No rotation, or half a turn. Of half a turn, each vector and its image add up to twice its part along the axis.
  const sums = pairs.map(([a, b]) => add(a, b));
  const longest = sums.reduce((best, one) => (length(one) > length(best) ? one : best));
  return { axis: normalize(longest, vec3(0, 0, 1)), angle };
}

/** Returns the cameras from one view to another, turned about one axis and zoomed evenly. */
function leg(from: Orbit, to: Orbit): Orbit[] {
  const start = orbitFrame(from);
  const { axis, angle } = rotationBetween(start, orbitFrame(to));
  const steps = Math.max(1, Math.ceil(effort(from, to) / sampleDegrees));
  return Array.from({ length: steps + 1 }, (_, i) => {
    if (i === steps) return to;
    const t = i / steps;
    const back = turnedAbout(start.back, axis, angle * t);
    const target = add(from.target, scale(subtract(to.target, from.target), t));
    const distance = from.distance * (to.distance / from.distance) ** t;
    const up = turnedAbout(start.up, axis, angle * t);
    return orbitOf({ eye: add(target, scale(back, distance)), target, up, verticalFovDegrees: to.verticalFovDegrees });
  });
}

/** Returns the way to the first view. A camera that is closer moves back before it turns, so that it crosses nothing. */
function wayTo(first: Orbit, from: Orbit): Orbit[] {
  if (from.distance >= first.distance) return leg(from, first);
  const far = { ...from, distance: first.distance };
  return [...leg(from, far), ...leg(far, first).slice(1)];
}

/**
 * Returns a tour through views that people chose, in their order: from the current camera to the nearest of them, through
 * all of them and back to it. It slows down at each. `aspect` is the shape of the picture. Precondition: there is a view.
 */
export function tourThrough(now: CameraPose, views: readonly TourView[], aspect: number): CameraPath {
  const { verticalFovDegrees } = now;
  const from = orbitOf(now);
  const orbits = views.map(({ eye, target, up }) => {
    const pose = { eye: toVec3(eye), target: toVec3(target), up: toVec3(up), verticalFovDegrees };
    return orbitOf(refitted(pose, 1, aspect));
  });
  const efforts = orbits.map((orbit) => effort(from, orbit));
  const nearest = efforts.indexOf(Math.min(...efforts));
  const inOrder = [...orbits.slice(nearest), ...orbits.slice(0, nearest)];
  const parts = inOrder.map((orbit, i) => leg(orbit, inOrder[(i + 1) % inOrder.length] ?? orbit).slice(1));
  const way = wayTo(inOrder[0] ?? from, from);
  const ends = parts.reduce((all, part) => [...all, (all.at(-1) ?? 0) + part.length], [way.length - 1]);
  return pathOf([...way, ...parts.flat()], ends);
}

/** Returns the cameras at which a path rests. */
export const restsOf = (path: CameraPath): CameraPose[] =>
  path.stops.map((stop) => path.orbits[path.along.indexOf(stop)]).flatMap((orbit) => (orbit ? [poseOf(orbit)] : []));
