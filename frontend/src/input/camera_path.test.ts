import { describe, expect, it } from "vitest";
import { orbitOf, poseOf, type CameraPose, type Orbit } from "./camera";
import {
  advanced,
  cameraAt,
  catmullRom,
  eased,
  keyCameras,
  mostTurn,
  refittedPath,
  roundTrip,
  tourOf,
  turnBetween,
  type Subject,
} from "./camera_path";
import { length, scale, subtract, vec3 } from "./vec3";

/** Returns a value that the test has put there. */
function sure<Value>(value: Value | null | undefined): Value {
  if (value === null || value === undefined) throw new Error("The value is missing.");
  return value;
}

const degree = Math.PI / 180;
const views = [-150, -90, -30, 15, 90, 150].map((azimuth, i) => ({
  azimuth: azimuth * degree,
  elevation: sure([5, 35, -25, 5, 35, 35][i]) * degree,
}));
const head: Subject = { low: vec3(-75, -95, -110), high: vec3(75, 95, 120) };
const middle = vec3(0, 0, 5);
const opening: CameraPose = {
  eye: vec3(300, -700, 150),
  target: vec3(0, 0, -10),
  up: vec3(0, 0, 1),
  verticalFovDegrees: 20,
};
const steps = (orbits: readonly Orbit[]) => orbits.slice(1).map((orbit, i) => turnBetween(sure(orbits[i]), orbit));

describe("a round trip", () => {
  it("passes through all views in order and is closed", () => {
    const curve = roundTrip(views);
    const passed = views.map((view) =>
      curve.findIndex((at) => Math.hypot(at.azimuth - view.azimuth, at.elevation - view.elevation) < 1e-9),
    );
    expect(passed).toEqual([...passed].sort((a, b) => a - b));
    expect(passed[0]).toBe(0);
    expect(curve.at(-1)?.azimuth).toBeCloseTo((curve[0]?.azimuth ?? 0) + 2 * Math.PI, 9);
    expect(curve.at(-1)?.elevation).toBe(curve[0]?.elevation);
  });
  it("never turns back, and has no kinks", () => {
    const curve = roundTrip(views);
    const speeds = curve.slice(1).map(({ azimuth }, i) => azimuth - sure(curve[i]).azimuth);
    expect(Math.min(...speeds)).toBeGreaterThan(0);
    const slopes = curve.slice(1).map(({ elevation }, i) => (elevation - sure(curve[i]).elevation) / sure(speeds[i]));
    // The largest change of slope on this curve is that of its second derivative, 10 per radian, over a step of 0.5 degrees.
    for (const [i, slope] of slopes.slice(1).entries()) expect(Math.abs(slope - sure(slopes[i]))).toBeLessThan(0.1);
  });
  it("interpolates as Catmull and Rom: a line stays a line, and tangents are half the distance of the neighbours", () => {
    expect(catmullRom(1, 2, 3, 4, 0.3)).toBeCloseTo(2.3, 12);
    const slope = (catmullRom(0, 1, 5, 2, 1e-6) - 1) / 1e-6;
    expect(slope).toBeCloseTo((5 - 0) / 2, 4);
  });
});

describe("a tour", () => {
  const path = tourOf(opening, views, head, 4 / 3);
  it("begins with the current camera and ends where the round trip began", () => {
    expect(length(subtract(cameraAt(path, 0)?.eye ?? middle, opening.eye))).toBeLessThan(1e-6);
    const [first, last] = path.stops.map((stop) => cameraAt(path, stop));
    expect(length(subtract(sure(first).eye, sure(last).eye))).toBeLessThan(1e-6);
    // The nearest view to an azimuth of -67 degrees.
    expect(orbitOf(sure(first)).azimuth).toBeCloseTo(-90 * degree, 6);
  });
  it("never turns by more than its length", () => {
    const turns = steps(path.orbits);
    turns.forEach((turn, i) => expect(turn).toBeLessThanOrEqual(sure(path.along[i + 1]) - sure(path.along[i]) + 1e-9));
    expect(Math.max(...turns)).toBeLessThan(mostTurn);
  });
  it.each([
    ["a narrow lens", 20, 4 / 3],
    ["a wide lens", 120, 4 / 3],
    ["a phone", 20, 390 / 600],
  ])("stays outside of all matter with %s", (_, verticalFovDegrees, aspect) => {
    const tour = tourOf({ ...opening, verticalFovDegrees }, views, head, aspect);
    for (const orbit of tour.orbits)
      expect(length(subtract(poseOf(orbit).eye, middle))).toBeGreaterThan(length(subtract(head.high, middle)));
  });
  it("moves back before it turns if the camera is close to the subject", () => {
    const close = { ...opening, eye: scale(opening.eye, 0.2), target: vec3(0, 0, 0) };
    const tour = tourOf(close, views, head, 1);
    const distances = tour.orbits.map((orbit) => length(subtract(poseOf(orbit).eye, middle)));
    const outside = distances.findIndex((one) => one > length(subtract(head.high, middle)));
    expect(Math.min(...distances.slice(outside))).toBeGreaterThan(length(subtract(head.high, middle)));
    expect(steps(tour.orbits.slice(0, outside)).every((turn) => turn < 1e-4)).toBe(true);
  });
  it("leaves the subject by the shortest way if it is behind the eye", () => {
    const past = { ...opening, eye: vec3(10, -90, 0), target: vec3(20, -300, 0) };
    const tour = tourOf(past, views, head, 1);
    const distances = tour.orbits.map((orbit) => length(subtract(poseOf(orbit).eye, middle)));
    const outside = distances.findIndex((one) => one > length(subtract(head.high, middle)));
    expect(Math.min(...distances.slice(outside))).toBeGreaterThan(length(subtract(head.high, middle)));
    for (let i = 1; i <= outside; ++i) expect(sure(distances[i])).toBeGreaterThan(sure(distances[i - 1]));
    expect(Math.max(...steps(tour.orbits))).toBeLessThan(mostTurn);
  });
  it("shows the whole subject in the picture from everywhere", () => {
    const tan = Math.tan(10 * degree);
    for (const at of keyCameras(path, 16)) {
      const distance = length(subtract(at.eye, at.target));
      expect(distance * tan).toBeGreaterThan(1.2 * 120); // the head from the middle to the top, with some room
    }
  });
  it("shows as much on a narrow picture", () => {
    const narrow = tourOf(opening, views, head, 0.5);
    expect(sure(narrow.orbits.at(-1)).distance).toBeCloseTo(
      2 * sure(tourOf(opening, views, head, 1).orbits.at(-1)).distance,
      6,
    );
    expect(sure(refittedPath(tourOf(opening, views, head, 1), 1, 0.5).orbits.at(-1)).distance).toBeCloseTo(
      sure(narrow.orbits.at(-1)).distance,
      6,
    );
  });
  it("has key views for a video at equal distances, the first and the last the same", () => {
    const keys = keyCameras(path, 16);
    expect(keys).toHaveLength(16);
    expect(length(subtract(sure(keys[0]).eye, sure(keys[15]).eye))).toBeLessThan(1e-6);
    const turns = steps(keys.map(orbitOf));
    expect(Math.max(...turns)).toBeLessThan(45);
  });
});

describe("the pace of a tour", () => {
  const path = tourOf(opening, views, head, 1);
  const end = sure(path.stops.at(-1));
  const middleOfLoop = (sure(path.stops[0]) + end) / 2;

  it("is constant between the stops and independent of the screen's rate", () => {
    const after = (ms: number, times: number) => {
      let at = middleOfLoop;
      for (let i = 0; i < times; ++i) at = advanced(path, at, ms, at);
      return at - middleOfLoop;
    };
    expect(after(10, 60)).toBeCloseTo(after(20, 30), 9);
    expect(after(10, 60)).toBeCloseTo(2 * after(10, 30), 9);
  });
  it("is never more than 3 degrees beyond the picture on the screen", () => {
    let at = middleOfLoop;
    for (let i = 0; i < 1000; ++i) at = advanced(path, at, 16, middleOfLoop); // no picture comes
    expect(at).toBeCloseTo(middleOfLoop + 3, 9);
  });
  it("does not catch up after a late frame", () => {
    expect(advanced(path, middleOfLoop, 60_000, middleOfLoop) - middleOfLoop).toBeLessThan(mostTurn);
  });
  it("is slow at the start and the end, but arrives", () => {
    const fast = advanced(path, middleOfLoop, 16, middleOfLoop) - middleOfLoop;
    expect(advanced(path, 0, 16, 0)).toBeLessThan(fast / 5);
    expect(advanced(path, 0, 16, 0)).toBeGreaterThan(0);
    let [at, frames] = [0, 0];
    while (at < end && frames++ < 10_000) at = advanced(path, at, 16, at);
    expect(at).toBe(end);
  });
});

describe("the way to a standard view", () => {
  it("moves back before it turns, so that it does not cross the subject", () => {
    const close = { ...opening, eye: vec3(0, -50, -10) };
    const to = { ...opening, eye: vec3(0, 700, -10) };
    const way = Array.from({ length: 101 }, (_, i) => orbitOf(eased(close, to, i / 100)));
    for (const orbit of way) if (turnBetween(sure(way[0]), orbit) > 1e-3) expect(orbit.distance).toBeCloseTo(700, 6);
  });
  it("is eased, on the shorter side, and ends exactly there", () => {
    const to = { ...opening, eye: vec3(-700, 300, -10) };
    expect(eased(opening, to, 1)).toBe(to);
    const whole = turnBetween(orbitOf(opening), orbitOf(to));
    const part = (t: number) => turnBetween(orbitOf(opening), orbitOf(eased(opening, to, t)));
    expect(part(0.1)).toBeLessThan(0.05 * whole);
    expect(part(0.5)).toBeCloseTo(0.5 * whole, -1);
  });
});
