import { describe, expect, it } from "vitest";
import { vec3 } from "../input/vec3";
import { isWhole, measured, withLastPoint, withPoint, withoutLast, type Measure } from "./measure";

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
