import { describe, expect, it } from "vitest";
import { orbitFrame, poseOf, type CameraPose } from "./camera";
import { keyCameras, turnBetween } from "./camera_path";
import { dot, length, subtract, vec3 } from "./vec3";
import { restsOf, tourThrough, type TourView } from "./view_tour";

const now: CameraPose = { eye: vec3(20, -600, 0), target: vec3(0, 0, 0), up: vec3(0, 0, 1), verticalFovDegrees: 30 };
const from = (...eye: readonly [number, number, number]): TourView => ({
  eye,
  target: [0, 0, 0],
  up: Math.abs(eye[2]) > Math.hypot(eye[0], eye[1]) ? [0, 1, 0] : [0, 0, 1],
});
const front = from(0, -500, 0);
const left = from(400, 0, 0);
const back = from(0, 500, 0);
const above = from(0, -4, 450);

function expectSmooth(views: readonly TourView[], camera = now): void {
  const { orbits } = tourThrough(camera, views, 1);
  const turns = orbits.slice(1).map((orbit, i) => turnBetween(orbits[i] ?? orbit, orbit));
  expect(Math.max(...turns)).toBeLessThan(0.75); // samples are at most 0.5 degrees apart, and 1 degree clamped at the poles
}

describe("A tour through given views", () => {
  it("begins at the nearest view, keeps the order and returns to it", () => {
    const rests = restsOf(tourThrough(now, [back, left, front], 1));
    const eyes = rests.map(({ eye }) => [eye.x, eye.y, eye.z].map((value) => Math.round(value)));
    expect(eyes).toEqual([front, back, left, front].map(({ eye }) => eye.map((value) => value)));
    expect(rests.every(({ up }) => Math.abs(up.z - 1) < 1e-9)).toBe(true);
  });
  it("turns evenly, also over the head and by half a turn", () => {
    expectSmooth([front, left, back]);
    expectSmooth([front, back]);
    expectSmooth([front, above, left]);
    expectSmooth([above, from(4, 0, -450)]);
  });
  it("turns on the shortest way between two views", () => {
    const { orbits } = tourThrough(now, [front, left], 1);
    const total = orbits.slice(1).reduce((sum, orbit, i) => sum + turnBetween(orbits[i] ?? orbit, orbit), 0);
    expect(total).toBeLessThan(3 + 90 + 90); // the way to the front is 2 degrees
  });
  it("never comes closer than the nearer of two views", () => {
    const far = from(0, -900, 0);
    for (const orbit of tourThrough({ ...now, eye: vec3(0, -900, 0) }, [far, left, back], 1).orbits)
      expect(length(subtract(poseOf(orbit).eye, orbit.target))).toBeGreaterThan(400 - 1e-6);
  });
  it("moves back before it turns, if the camera is closer", () => {
    const close = { ...now, eye: vec3(0, 50, 0) };
    const turned = tourThrough(close, [front], 1).orbits.find(
      (orbit) => dot(orbitFrame(orbit).back, vec3(0, 1, 0)) < 0.999,
    );
    expect(turned?.distance).toBeGreaterThan(499);
  });
  it("moves back in a narrow window, which shows less", () => {
    const [view] = restsOf(tourThrough(now, [front], 0.5));
    expect(view?.eye.y).toBeCloseTo(-1000);
  });
  it("gives a video its key views", () => {
    const path = tourThrough(now, [front, left, back], 1);
    const keys = keyCameras(path, 16);
    expect(keys.length).toBe(16);
    expect(keys.at(-1)?.eye.y).toBeCloseTo(-500);
  });
});
