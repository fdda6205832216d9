import { describe, expect, it } from "vitest";
import { vec3 } from "../input/vec3";
import { is_whole, measured, with_last_point, with_point, without_last, type Measure } from "./measure";

const ruler = (...points: Measure["points"]): Measure => ({ kind: "ruler", plane: "axial", slice: 1, points });

describe("measuring", () => {
  it("is in millimetres and degrees", () => {
    expect(measured(ruler(vec3(0, 0, 0), vec3(3, 4, 12)))).toBe(13);
    expect(measured({ ...ruler(vec3(1, 0, 0), vec3(0, 0, 0), vec3(0, 5, 0)), kind: "angle" })).toBeCloseTo(90);
    expect(measured({ ...ruler(vec3(2, 1, 1), vec3(1, 1, 1), vec3(2, 2, 1)), kind: "angle" })).toBeCloseTo(45);
  });
  it("says nothing where points are lacking or lie upon each other", () => {
    expect(measured(ruler(vec3(0, 0, 0)))).toBeNull();
    expect(measured({ ...ruler(vec3(0, 0, 0), vec3(0, 0, 0), vec3(1, 0, 0)), kind: "angle" })).toBeNull();
  });
  it("goes on with the last one, and begins anew in another slice or of another kind", () => {
    const one = with_point([], "ruler", "axial", 1, vec3(0, 0, 0));
    const two = with_point(one, "ruler", "axial", 1, vec3(1, 0, 0));
    expect(two.map(is_whole)).toEqual([true]);
    expect(with_point(two, "ruler", "axial", 1, vec3(9, 0, 0))).toHaveLength(2);
    expect(with_point(one, "ruler", "axial", 2, vec3(1, 0, 0))).toEqual([{ ...ruler(vec3(1, 0, 0)), slice: 2 }]);
    expect(with_point(one, "angle", "axial", 1, vec3(1, 0, 0))).toHaveLength(1);
    expect(with_last_point(two, vec3(5, 0, 0))[0]?.points).toEqual([vec3(0, 0, 0), vec3(5, 0, 0)]);
    expect(without_last(two)).toEqual([]);
  });
});
