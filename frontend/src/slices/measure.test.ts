import { describe, expect, it } from "vitest";
import { length, subtract, vec3, type Vec3 } from "../input/vec3";
import {
  handleNear,
  handlesOf,
  isWhole,
  measured,
  withHandle,
  withLastPoint,
  withPoint,
  withoutLast,
  type Measure,
} from "./measure";
import { axial, coronal } from "./testing";

const ruler = (...points: Measure["points"]): Measure => ({ kind: "ruler", plane: "axial", slice: 1, points });

describe("a measurement", () => {
  it("is in millimetres or degrees", () => {
    expect(measured(ruler(vec3(0, 0, 0), vec3(3, 4, 12)))).toBe(13);
    expect(measured({ ...ruler(vec3(1, 0, 0), vec3(0, 0, 0), vec3(0, 5, 0)), kind: "angle" })).toBeCloseTo(90);
    expect(measured({ ...ruler(vec3(2, 1, 1), vec3(1, 1, 1), vec3(2, 2, 1)), kind: "angle" })).toBeCloseTo(45);
  });
  it("has no value while points are missing or coincide", () => {
    expect(measured(ruler(vec3(0, 0, 0)))).toBeNull();
    expect(measured({ ...ruler(vec3(0, 0, 0), vec3(0, 0, 0), vec3(1, 0, 0)), kind: "angle" })).toBeNull();
  });
  it("continues the last one, but starts a new one in another slice or of another kind", () => {
    const one = withPoint([], "ruler", "axial", 1, vec3(0, 0, 0));
    const two = withPoint(one, "ruler", "axial", 1, vec3(1, 0, 0));
    expect(two.map(isWhole)).toEqual([true]);
    expect(withPoint(two, "ruler", "axial", 1, vec3(9, 0, 0))).toHaveLength(2);
    expect(withPoint(one, "ruler", "axial", 2, vec3(1, 0, 0))).toEqual([{ ...ruler(vec3(1, 0, 0)), slice: 2 }]);
    expect(withPoint(one, "angle", "axial", 1, vec3(1, 0, 0))).toHaveLength(1);
    expect(withLastPoint(two, vec3(5, 0, 0))[0]?.points).toEqual([vec3(0, 0, 0), vec3(5, 0, 0)]);
    expect(withoutLast(two)).toEqual([]);
  });
});

describe("the handles of a measurement", () => {
  const ellipse: Measure = { kind: "ellipse", plane: "coronal", slice: 1, points: [vec3(-2, 0, 5), vec3(1, 0, -4)] };
  it("are its points, or the ends of an ellipse and its centre", () => {
    expect(handlesOf(axial, ruler(vec3(1, 2, 0), vec3(3, 4, 0)))).toEqual([vec3(1, 2, 0), vec3(3, 4, 0)]);
    const handles = handlesOf(coronal, ellipse);
    const expected = [vec3(-2, 0, 0.5), vec3(1, 0, 0.5), vec3(-0.5, 0, 5), vec3(-0.5, 0, -4), vec3(-0.5, 0, 0.5)];
    handles.forEach((at, i) => expect(length(subtract(at, expected[i] ?? at))).toBeCloseTo(0));
  });
  it("resize an ellipse along one direction, or move all of it", () => {
    const moved = (handle: number, to: Vec3) =>
      withHandle(coronal, ellipse, handle, to).points.map(({ x, z }) => [x, z].map((n) => Math.round(1e6 * n) / 1e6));
    expect(moved(1, vec3(2, 0, 9))).toEqual([
      [-2, 5],
      [2, -4],
    ]);
    expect(moved(2, vec3(9, 0, 3))).toEqual([
      [-2, 3],
      [1, -4],
    ]);
    expect(moved(4, vec3(0, 0, 1))).toEqual([
      [-1.5, 5.5],
      [1.5, -3.5],
    ]);
    // Dragged past the opposite end, it is mirrored and stays an ellipse.
    expect(moved(0, vec3(4, 0, 0))).toEqual([
      [4, 5],
      [1, -4],
    ]);
  });
  it("are found near a point in the same slice only, the nearest first", () => {
    const measures = [ruler(vec3(0, 0, 0), vec3(3, 0, 0)), ruler(vec3(1, 0, 0), vec3(0, 4, 0))];
    expect(handleNear(measures, axial, 1, vec3(0.8, 0, 0), 1)).toEqual({ measure: 1, handle: 0 });
    expect(handleNear(measures, axial, 1, vec3(2, 0.5, 0), 1.5)).toEqual({ measure: 1, handle: 0 });
    expect(handleNear(measures, axial, 1, vec3(2, 2, 0), 1)).toBeNull();
    expect(handleNear(measures, axial, 2, vec3(0, 0, 0), 1)).toBeNull();
    expect(handleNear(measures, coronal, 1, vec3(0, 0, 0), 1)).toBeNull();
  });
});
