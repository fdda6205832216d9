import { describe, expect, it } from "vitest";
import { dot, length, subtract, vec3, type Vec3 } from "../input/vec3";
import { Curve, turnedAcross } from "./curve";

function expectNear(got: Vec3 | undefined, expected: Vec3, tolerance: number): void {
  expect(got && length(subtract(got, expected))).toBeLessThanOrEqual(tolerance);
}
const through = (...points: readonly (readonly [number, number, number])[]): Curve =>
  Curve.through(points.map((point) => vec3(...point))) ?? expect.unreachable();

describe("a curve", () => {
  // The numbers and the tolerance are those of volume/curve_test.cpp, so that the page and the server agree.
  it("equals an independent computation", () => {
    const curve = through([-30, 5, -20], [-10, 25, -5], [15, 10, 0], [20, -20, 25], [40, -25, 60]);
    const tolerance = ((0.7 * 0.7) / 25 / 24) * curve.length;
    expect(Math.abs(curve.length - 144.1595204)).toBeLessThanOrEqual(tolerance);
    const second = curve.at(29.9991214);
    expectNear(second.place, vec3(-12.253648, 24.468386, -6.098287), tolerance);
    expectNear(second.along, vec3(0.83177, 0.325385, 0.449758), tolerance / 5);
    expectNear(second.across, vec3(0.541101, -0.656163, -0.525984), tolerance / 5);
    expectNear(curve.at(74.9972816).across, vec3(-0.274635, -0.55783, -0.783199), tolerance / 5);
    expectNear(curve.at(144.16).place, vec3(40, -25, 60), 1e-9);
    expectNear(curve.at(144.16).across, vec3(-0.051596, -0.992347, -0.112183), 1e-3);
  });
  it("has the arc length of a helix", () => {
    const [radius, rise, points] = [20, 5, 60];
    const step = (6 * Math.PI) / (points - 1);
    const helix = Curve.through(
      Array.from({ length: points }, (_, i) =>
        vec3(radius * Math.cos(i * step), radius * Math.sin(i * step), rise * i * step),
      ),
    );
    const exact = 6 * Math.PI * Math.hypot(radius, rise);
    // As derived in volume/curve_test.cpp.
    const part = step ** 4 * (1 / 48 + 1 / 384) + (2 / (points - 1)) * 0.2 * step ** 2;
    expect(Math.abs((helix?.length ?? 0) - exact)).toBeLessThanOrEqual(part * exact);
  });
  it("is straight through collinear points, and leaves out doubled ones", () => {
    for (const curve of [through([-10, 0, 0], [20, 0, 0]), through([-10, 0, 0], [5, 0, 0], [5, 0, 0], [20, 0, 0])]) {
      expect(curve.length).toBeCloseTo(30, 9);
      expectNear(curve.at(12).across, vec3(0, 0, -1), 1e-9);
    }
  });
  it("keeps its direction across where it turns back on itself", () => {
    const curve = through([0, 0, 0], [20, 0, 0], [0, 0, 0]);
    expect(curve.length).toBeCloseTo(40, 9);
    expectNear(curve.at(30).along, vec3(-1, 0, 0), 1e-9);
    expectNear(curve.at(30).across, vec3(0, 0, -1), 1e-9);
  });
  it("needs two different points", () => {
    expect(Curve.through([])).toBeNull();
    expect(Curve.through([vec3(1, 2, 3), vec3(1, 2, 3)])).toBeNull();
  });
  it("begins across the axis that is least parallel to it", () => {
    expectNear(through([-40, 20, 3], [0, -20, 3], [40, 20, 3]).at(0).across, vec3(0, 0, -1), 1e-9);
    expectNear(through([1, -5, 90], [1, 15, 0], [1, -5, -90]).at(0).across, vec3(1, 0, 0), 1e-9);
  });
  it("finds the nearest arc length of a place", () => {
    const { arc, away } = through([0, 0, 0], [10, 0, 0]).nearest(vec3(3, 4, 0));
    expect(arc).toBeCloseTo(3, 6);
    expect(away).toBeCloseTo(4, 6);
  });
  it("turns rows about itself", () => {
    const frame = through([0, 0, 0], [10, 0, 0]).at(5);
    expectNear(turnedAcross(frame, 90), vec3(0, 1, 0), 1e-9);
    expectNear(turnedAcross(frame, 180), vec3(0, 0, 1), 1e-9);
    expect(dot(turnedAcross(frame, 30), frame.along)).toBeCloseTo(0, 12);
  });
});
