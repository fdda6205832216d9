import { orbitFrame, orbitOf, poseOf, refitted, type CameraPose, type Orbit } from "./camera";
import { add, dot, length, scale, subtract, vec3, type Vec3 } from "./vec3";

/** A direction from which to look, in radians, as in Orbit. */
export interface ViewDirection {
  readonly azimuth: number;
  readonly elevation: number;
}

/** The box around all visible matter, in mm. */
export interface Subject {
  readonly low: Vec3;
  readonly high: Vec3;
}

/** A path of the camera. `along` rises from 0 and never slower than the camera turns, in degrees. */
export interface CameraPath {
  readonly orbits: readonly Orbit[];
  readonly along: readonly number[];
  /** Where along the path the camera comes to rest, the last of them at its end. */
  readonly stops: readonly number[];
}

const degree = Math.PI / 180;
const fullTurn = 2 * Math.PI;
/** Between neighbouring samples of a path. */
export const sampleDegrees = 0.5;
const sampleStep = sampleDegrees * degree;
/** Degrees that count for a zoom by a factor of e, and for moving the target by the distance of the eye. */
const zoomDegrees = 40;
const panDegrees = 60;
/** Like the server frames its looks (place_camera in renderd/scene/presets.cpp), with a smaller margin, because all directions fit. */
const margin = 1.4;
const raised = 0.08;
/** The least distance of the eye from the middle of the subject, in radii of the sphere around it. */
const leastDistance = 1.1;

const nearestTurn = (angle: number): number => angle - fullTurn * Math.round(angle / fullTurn);
const mix = (a: number, b: number, t: number): number => a + (b - a) * t;
const middleOf = ({ low, high }: Subject): Vec3 => scale(add(low, high), 0.5);
const radiusOf = ({ low, high }: Subject): number => length(subtract(high, low)) / 2;

/** Returns the camera at the part `t` of the way, turned on the shorter side and zoomed evenly. */
export function between(a: Orbit, b: Orbit, t: number): Orbit {
  return {
    target: add(a.target, scale(subtract(b.target, a.target), t)),
    distance: a.distance * (b.distance / a.distance) ** t,
    azimuth: a.azimuth + nearestTurn(b.azimuth - a.azimuth) * t,
    elevation: mix(a.elevation, b.elevation, t),
    roll: a.roll + nearestTurn(b.roll - a.roll) * t,
    verticalFovDegrees: mix(a.verticalFovDegrees, b.verticalFovDegrees, t),
  };
}

/**
 * Returns the camera on the way to another one, slow at both ends. A camera that is closer than that one moves back
 * before it turns, so that it does not cross what it looks at.
 */
export function eased(from: CameraPose, to: CameraPose, t: number): CameraPose {
  if (t >= 1) return to;
  const [begin, end] = [orbitOf(from), orbitOf(to)];
  const s = t * t * (3 - 2 * t);
  if (begin.distance >= end.distance) return poseOf(between(begin, end, s));
  const far = { ...begin, distance: end.distance };
  const back = 0.4;
  return poseOf(s < back ? between(begin, far, s / back) : between(far, end, (s - back) / (1 - back)));
}

/** Returns the angle in degrees of the rotation between two cameras. */
export function turnBetween(a: Orbit, b: Orbit): number {
  const [p, q] = [orbitFrame(a), orbitFrame(b)];
  const trace = dot(p.right, q.right) + dot(p.up, q.up) + dot(p.back, q.back);
  return Math.acos(Math.min(1, Math.max(-1, (trace - 1) / 2))) / degree;
}

/** Returns how much the camera moves between two places, in degrees. Zooming and panning count too. */
export function effort(a: Orbit, b: Orbit): number {
  const zoom = zoomDegrees * Math.abs(Math.log(b.distance / a.distance));
  const pan = (panDegrees * length(subtract(b.target, a.target))) / Math.min(a.distance, b.distance);
  return Math.max(turnBetween(a, b), zoom, pan);
}

/** Returns a closed curve (Catmull-Rom) through directions of rising azimuth, once around. */
export function roundTrip(views: readonly ViewDirection[]): ViewDirection[] {
  const n = views.length;
  const at = (i: number): ViewDirection => {
    const view = views[((i % n) + n) % n] ?? { azimuth: 0, elevation: 0 };
    return { ...view, azimuth: view.azimuth + fullTurn * Math.floor(i / n) };
  };
  const curve: ViewDirection[] = [];
  for (let i = 0; i < n; ++i) {
    const points = [at(i - 1), at(i), at(i + 1), at(i + 2)] as const;
    const steps = Math.max(1, Math.ceil((points[2].azimuth - points[1].azimuth) / sampleStep));
    for (let k = 0; k < steps; ++k) {
      const through = (of: keyof ViewDirection) =>
        catmullRom(points[0][of], points[1][of], points[2][of], points[3][of], k / steps);
      curve.push({ azimuth: through("azimuth"), elevation: through("elevation") });
    }
  }
  return [...curve, at(n)];
}

/** Returns the point between `b` and `c` of the curve through four points. */
export const catmullRom = (a: number, b: number, c: number, d: number, t: number): number =>
  b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));

/** Returns half the width along a direction of the ellipsoid that touches the faces of the box. */
function halfWidth({ low, high }: Subject, along: Vec3): number {
  const half = scale(subtract(high, low), 0.5);
  return length(vec3(half.x * along.x, half.y * along.y, half.z * along.z));
}

/**
 * Returns the place for the camera from which the subject fits a square picture in all directions.
 * It is outside of the sphere around the subject.
 */
function framed(directions: readonly ViewDirection[], subject: Subject, verticalFovDegrees: number): Orbit {
  const toOrbit = (direction: ViewDirection): Orbit => ({
    ...direction,
    target: middleOf(subject),
    distance: 1,
    roll: 0,
    verticalFovDegrees,
  });
  const halfHeight =
    margin *
    Math.max(
      ...directions.map((direction) => {
        const { up, right } = orbitFrame(toOrbit(direction));
        return Math.max(halfWidth(subject, up), 0.9 * halfWidth(subject, right));
      }),
    );
  const target = add(middleOf(subject), vec3(0, 0, -raised * halfHeight));
  const least = leastDistance * radiusOf(subject) + raised * halfHeight;
  const distance = Math.max(halfHeight / Math.tan((verticalFovDegrees / 2) * degree), least);
  return { ...toOrbit({ azimuth: 0, elevation: 0 }), target, distance };
}

const sampled = (from: Orbit, to: Orbit): Orbit[] => {
  const steps = Math.max(1, Math.ceil(effort(from, to) / sampleDegrees));
  return Array.from({ length: steps + 1 }, (_, i) => between(from, to, i / steps));
};

const eyeInside = (orbit: Orbit, subject: Subject): boolean =>
  length(subtract(poseOf(orbit).eye, middleOf(subject))) < leastDistance * radiusOf(subject);

/** Returns the camera moved straight away from the middle of the subject until its eye is outside. */
function backedOff(from: Orbit, subject: Subject): Orbit {
  const eye = subtract(poseOf(from).eye, middleOf(subject));
  const away = length(eye) > 1e-6 ? scale(eye, 1 / length(eye)) : orbitFrame(from).back;
  const missing = leastDistance * radiusOf(subject) - length(eye);
  return missing > 0 ? { ...from, target: add(from.target, scale(away, 1.001 * missing)) } : from;
}

/**
 * Returns the way to the first view of a tour. If the direct one led through the subject, the camera first leaves it by
 * the shortest way, then turns to its middle, and only then turns around it.
 */
function approach(from: Orbit, to: Orbit, subject: Subject): Orbit[] {
  const direct = sampled(from, to);
  if (!direct.some((orbit) => eyeInside(orbit, subject))) return direct;
  const outside = backedOff(from, subject);
  const second = sampled(outside, to);
  if (!second.some((orbit) => eyeInside(orbit, subject))) return [...sampled(from, outside), ...second.slice(1)];
  // Looking at the target of the tour from the same place.
  const { eye, up } = poseOf(outside);
  const facing = orbitOf({ eye, up, target: to.target, verticalFovDegrees: from.verticalFovDegrees });
  const far = { ...facing, distance: Math.max(facing.distance, to.distance) };
  return [...sampled(from, outside), ...turned(outside, facing), ...sampled(facing, far), ...sampled(far, to).slice(1)];
}

/** Returns the cameras that turn from one to the other at the place of the eye. */
function turned(from: Orbit, to: Orbit): Orbit[] {
  const { eye } = poseOf(from);
  const steps = Math.max(1, Math.ceil(turnBetween(from, to) / (sampleStep / degree)));
  return Array.from({ length: steps + 1 }, (_, i) => {
    const orbit = between(from, to, i / steps);
    return { ...orbit, target: subtract(eye, scale(orbitFrame(orbit).back, orbit.distance)) };
  });
}

/**
 * Returns a tour: from the current camera to the nearest of the views, and once around through all of them. `aspect` is
 * the shape of the picture. Precondition: there is a view.
 */
export function tourOf(now: CameraPose, views: readonly ViewDirection[], subject: Subject, aspect: number): CameraPath {
  const from = orbitOf(now);
  const turnTo = (view: ViewDirection) => Math.abs(nearestTurn(view.azimuth - from.azimuth));
  const first = views.reduce((best, view, i) => (turnTo(view) < turnTo(views[best] ?? view) ? i : best), 0);
  const inOrder = views.map((_, i) => {
    const view = views[(first + i) % views.length] ?? { azimuth: 0, elevation: 0 };
    return first + i < views.length ? view : { ...view, azimuth: view.azimuth + fullTurn };
  });
  const round = roundTrip(inOrder);
  const place = framed(round, subject, now.verticalFovDegrees);
  const fitted = orbitOf(refitted(poseOf(place), 1, aspect));
  const loop = round.map((direction) => ({ ...fitted, ...direction }));
  const to = loop[0] ?? from;
  const way = approach(from, to, subject);
  const orbits = [...way, ...loop.slice(1)];
  return pathOf(orbits, [way.length - 1, orbits.length - 1]);
}

/** Returns the path through cameras that are close to each other. It rests at those with the indices `rests`. */
export function pathOf(orbits: readonly Orbit[], rests: readonly number[]): CameraPath {
  const along = [0];
  for (const [i, orbit] of orbits.entries()) {
    const before = orbits[i - 1];
    if (before) along.push((along[i - 1] ?? 0) + effort(before, orbit));
  }
  return { orbits, along, stops: rests.map((index) => along[index] ?? 0) };
}

/** Returns the camera at a place along a path. */
export function cameraAt({ orbits, along }: CameraPath, at: number): CameraPose | null {
  const above = along.findIndex((one) => one >= at);
  const [after, before] = [orbits[above], orbits[above - 1]];
  const last = orbits.at(-1);
  if (!after) return last ? poseOf(last) : null;
  if (!before) return poseOf(after);
  const [low = 0, high = 0] = [along[above - 1], along[above]];
  return poseOf(between(before, after, high > low ? (at - low) / (high - low) : 1));
}

/** Returns a path for a picture of another shape. */
export const refittedPath = (path: CameraPath, aspectBefore: number, aspect: number): CameraPath => ({
  ...path,
  orbits: path.orbits.map((orbit) => orbitOf(refitted(poseOf(orbit), aspectBefore, aspect))),
});

/** Returns cameras at equal distances of the round trip, for a video. */
export function keyCameras(path: CameraPath, count: number): CameraPose[] {
  const [begin = 0] = path.stops;
  const end = path.stops.at(-1) ?? begin;
  return Array.from({ length: count }, (_, i) => cameraAt(path, mix(begin, end, i / (count - 1)))).filter(
    (pose) => pose !== null,
  );
}

/** The most that the camera turns between two pictures that are shown, in degrees. */
export const mostTurn = 3;
const degreesPerSecond = 14;
/** Within this distance of a stop, in degrees, the camera is slower. */
const easedDegrees = 8;
const slowest = 0.06;
/** A late frame counts as this long, so that the camera never catches up by a jump. */
const longestFrameMs = 100;

/**
 * Returns the next place along a path: at a constant speed but slow near stops, and at most `mostTurn` beyond `shown`,
 * the place of the picture on the screen. So no picture is skipped, however slowly the server renders.
 */
export function advanced(path: CameraPath, at: number, elapsedMs: number, shown: number): number {
  const end = path.stops.at(-1) ?? 0;
  const toStop = Math.min(at, ...path.stops.map((stop) => Math.abs(stop - at)));
  const speed = degreesPerSecond * Math.max(slowest, Math.min(1, Math.sqrt(toStop / easedDegrees)));
  const next = at + (speed * Math.min(Math.max(elapsedMs, 0), longestFrameMs)) / 1000;
  return Math.max(at, Math.min(next, shown + mostTurn, end));
}
