import { describe, expect, it } from "vitest";
import { vec3 } from "../input/vec3";
import { edgesOf, heldWithin, inSlice, isInside, pixelOf, placeOf, placeParts, sideOf, spotOf } from "./stack";
import { axial, coronal, sagittal } from "./testing";

describe("a point", () => {
  it("maps to a pixel and back in every plane", () => {
    const place = vec3(1.5, -1, 3);
    for (const stack of [axial, coronal, sagittal]) expect(placeOf(stack, spotOf(stack, place))).toEqual(place);
    expect(pixelOf(axial, place)).toEqual({ column: 4, row: 1, slice: 3 });
    expect(pixelOf(coronal, place)).toEqual({ column: 4, row: 1, slice: 1 });
    expect(pixelOf(sagittal, place)).toEqual({ column: 1, row: 1, slice: 4 });
  });
  it("outside is limited to the edge, and keeps its position when it moves to another slice", () => {
    expect(heldWithin(axial, vec3(100, -100, 0))).toEqual(vec3(2.5, -3, 0));
    expect(inSlice(axial, vec3(0.25, 0.5, 0), 4)).toEqual(vec3(0.25, 0.5, 6));
    expect(inSlice(axial, vec3(0, 0, 0), 77).z).toBe(6);
    expect(inSlice(axial, vec3(0, 0, 0), -1).z).toBe(-6);
  });
  it("is described by the sides of the patient", () => {
    expect(placeParts(vec3(-2, 3, -4.5))).toEqual([
      { side: "R", mm: 2 },
      { side: "P", mm: 3 },
      { side: "I", mm: 4.5 },
    ]);
  });
  it("is inside or outside a rotated box", () => {
    const c = Math.SQRT1_2;
    const box = { size: [10, 10, 2], spacing: [1, 1, 1], direction: [c, -c, 0, c, c, 0, 0, 0, 1] };
    expect(isInside(box, vec3(7, 0, 0))).toBe(true);
    expect(isInside(box, vec3(4.9, 4.9, 0))).toBe(false);
    expect(isInside(box, vec3(0, 0, 1.1))).toBe(false);
  });
});

describe("the letters", () => {
  it("follow the radiological convention", () => {
    expect(edgesOf(axial)).toEqual({ left: "R", right: "L", top: "A", bottom: "P" });
    expect(edgesOf(coronal)).toEqual({ left: "R", right: "L", top: "S", bottom: "I" });
    expect(edgesOf(sagittal)).toEqual({ left: "A", right: "P", top: "S", bottom: "I" });
    expect(sideOf(vec3(0.1, 0, -2))).toBe("I");
  });
});
