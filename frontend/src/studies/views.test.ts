import { describe, expect, it } from "vitest";
import { dot, length, subtract, vec3 } from "../input/vec3";
import { orbitOf } from "../input/camera";
import { cameraValue, facingError, isOffTarget, randomView } from "./views";

const preset = { eye: vec3(0, -500, 40), target: vec3(10, 0, 40), up: vec3(0, 0, 1), verticalFovDegrees: 30 };

describe("a random view", () => {
  const views = Array.from({ length: 4000 }, (_, seed) => randomView(seed, "step", preset));
  const backs = views.map(({ eye, target }) => subtract(eye, target));
  const distance = length(subtract(preset.eye, preset.target));

  it("keeps the target, the distance and the lens, and the head up", () => {
    for (const [i, view] of views.entries()) {
      expect(view.target).toEqual(preset.target);
      expect(view.verticalFovDegrees).toBe(30);
      expect(length(backs[i] ?? vec3(0, 0, 0))).toBeCloseTo(distance, 6);
      expect(length(view.up)).toBeCloseTo(1, 9);
      expect(dot(view.up, backs[i] ?? vec3(1, 1, 1))).toBeCloseTo(0, 6);
      expect(Math.abs(orbitOf(view).roll)).toBeLessThan(1e-6);
      expect(view.up.z).toBeGreaterThanOrEqual(0);
    }
  });

  it("is uniform on the sphere", () => {
    // On a sphere, the height is uniform (Archimedes), and so is the azimuth. Kolmogorov and Smirnov, significance
    // 0.001 for each of the two: 1.95 / sqrt(n).
    const largest = (values: number[]) =>
      Math.max(...values.sort((a, b) => a - b).map((value, i) => Math.abs(value - (i + 0.5) / values.length)));
    const limit = 1.95 / Math.sqrt(views.length);
    expect(largest(backs.map(({ z }) => (z / distance + 1) / 2))).toBeLessThan(limit);
    expect(largest(backs.map(({ x, y }) => Math.atan2(y, x) / (2 * Math.PI) + 0.5))).toBeLessThan(limit);
  });

  it("depends on the participant and the step only", () => {
    expect(randomView(5, "a", preset)).toEqual(randomView(5, "a", preset));
    expect(randomView(5, "b", preset)).not.toEqual(randomView(5, "a", preset));
    expect(randomView(6, "a", preset)).not.toEqual(randomView(5, "a", preset));
  });
});

describe("the error of a latency task", () => {
  it("is the angle between the directions to the eye and to the region", () => {
    const at = (x: number, y: number, z: number) => vec3(preset.target.x + x, preset.target.y + y, preset.target.z + z);
    const straight = { ...preset, eye: at(0, -500, 0) };
    expect(facingError(straight, at(0, -50, 0))).toBeCloseTo(0, 6);
    expect(facingError(straight, at(0, 50, 0))).toBeCloseTo(180, 6);
    expect(facingError(straight, at(0, 0, 30))).toBeCloseTo(90, 6);
    expect(facingError(straight, at(20, -20, 0))).toBeCloseTo(45, 6);
    expect(facingError(straight, straight.target)).toBe(0);
  });

  it("needs a region beside the target", () => {
    const region = (x: number) => ({ name: {}, centre: [x, 0, 0] as const, radius: 10 });
    expect(isOffTarget(region(0.5), vec3(0, 0, 0))).toBe(false);
    expect(isOffTarget(region(1.5), vec3(0, 0, 0))).toBe(true);
  });
});

it("a camera is stored as arrays", () => {
  expect(cameraValue(preset)).toEqual({ eye: [0, -500, 40], target: [10, 0, 40], up: [0, 0, 1] });
});
