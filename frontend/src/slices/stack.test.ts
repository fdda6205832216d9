import { describe, expect, it } from "vitest";
import { vec3 } from "../input/vec3";
import { edges_of, held_within, in_slice, is_inside, pixel_of, place_of, said_place, side_of, spot_of } from "./stack";
import { axial, coronal, sagittal } from "./testing";

describe("a place", () => {
  it("is found again in every plane", () => {
    const place = vec3(1.5, -1, 3);
    for (const stack of [axial, coronal, sagittal]) expect(place_of(stack, spot_of(stack, place))).toEqual(place);
    expect(pixel_of(axial, place)).toEqual({ column: 4, row: 1, slice: 3 });
    expect(pixel_of(coronal, place)).toEqual({ column: 4, row: 1, slice: 1 });
    expect(pixel_of(sagittal, place)).toEqual({ column: 1, row: 1, slice: 4 });
  });
  it("outside is held at the border, and moves to another slice without moving in it", () => {
    expect(held_within(axial, vec3(100, -100, 0))).toEqual(vec3(2.5, -3, 0));
    expect(in_slice(axial, vec3(0.25, 0.5, 0), 4)).toEqual(vec3(0.25, 0.5, 6));
    expect(in_slice(axial, vec3(0, 0, 0), 77).z).toBe(6);
    expect(in_slice(axial, vec3(0, 0, 0), -1).z).toBe(-6);
  });
  it("is said by the sides of the patient", () => {
    expect(said_place(vec3(-2, 3, -4.5))).toEqual([{ side: "R", mm: 2 }, { side: "P", mm: 3 }, { side: "I", mm: 4.5 }]);
  });
  it("lies in a turned box or not", () => {
    const c = Math.SQRT1_2;
    const box = { size: [10, 10, 2], spacing: [1, 1, 1], direction: [c, -c, 0, c, c, 0, 0, 0, 1] };
    expect(is_inside(box, vec3(7, 0, 0))).toBe(true);
    expect(is_inside(box, vec3(4.9, 4.9, 0))).toBe(false);
    expect(is_inside(box, vec3(0, 0, 1.1))).toBe(false);
  });
});

describe("the letters", () => {
  it("are those of the radiological convention", () => {
    expect(edges_of(axial)).toEqual({ left: "R", right: "L", top: "A", bottom: "P" });
    expect(edges_of(coronal)).toEqual({ left: "R", right: "L", top: "S", bottom: "I" });
    expect(edges_of(sagittal)).toEqual({ left: "A", right: "P", top: "S", bottom: "I" });
    expect(side_of(vec3(0.1, 0, -2))).toBe("I");
  });
});
