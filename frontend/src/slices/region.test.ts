import { describe, expect, it } from "vitest";
import { vec3 } from "../input/vec3";
import type { Measure } from "./measure";
import { regionOf, type Measurable } from "./region";
import { blank, placeOf, type Stack } from "./stack";

/** A slice of 120 x 90 pixels of 0.5 x 1.25 mm. */
const stack: Stack = {
  plane: "axial",
  columns: 120,
  rows: 90,
  slices: 1,
  first: vec3(-30, -55, 4),
  right: vec3(0.5, 0, 0),
  down: vec3(0, 1.25, 0),
  next: vec3(0, 0, 2),
};

function slice(value: (column: number, row: number) => number, more: Partial<Measurable> = {}): Measurable {
  const values = new Int16Array(stack.columns * stack.rows).map((_, i) =>
    value(i % stack.columns, Math.floor(i / stack.columns)),
  );
  return { values, isInside: () => true, clipped: false, ...more };
}

/** The ellipse around a centre with half of its size, in pixels. */
function ellipse(column: number, row: number, across: number, down: number): Measure {
  const corner = (side: number) => placeOf(stack, { column: column + side * across, row: row - side * down, slice: 0 });
  return { kind: "ellipse", plane: "axial", slice: 0, points: [corner(-1), corner(1)] };
}

describe("the values in an ellipse", () => {
  it("are those of the pixels whose centre is inside", () => {
    // Of the 3 x 3 pixels around (10, 20), all but the corners.
    const pixels = slice((x, y) => (x - 10) * 100 + (y - 20) * 10 + 7);
    const region = regionOf(stack, ellipse(10, 20, 1.2, 1.2), pixels);
    expect(region).toMatchObject({ pixels: 5, mean: 7, minimum: -93, maximum: 107 });
    expect(region?.deviation).toBeCloseTo(Math.sqrt((2 * 100 ** 2 + 2 * 10 ** 2) / 5), 9);
  });
  it("are those of its own place if it was made in an oblique slice, which has no number", () => {
    const deep: Stack = { ...stack, slices: 41 };
    const at = (one: Measure): Measure => ({
      ...one,
      plane: null,
      points: one.points.map((point) => vec3(point.x, point.y, point.z + 60)),
    });
    const isInside = (place: { readonly z: number }) => Math.abs(place.z - 64) < 1;
    expect(
      regionOf(
        deep,
        at(ellipse(10, 20, 1.2, 1.2)),
        slice(() => 5, { isInside }),
      )?.pixels,
    ).toBe(5);
  });
  it("do not include the surroundings of a phantom", () => {
    const phantom = slice((x, y) => (Math.hypot((x - 60) / 30, (y - 45) / 20) <= 1 ? 100 : -1000));
    expect(regionOf(stack, ellipse(60, 45, 29, 19), phantom)).toMatchObject({ mean: 100, deviation: 0, minimum: 100 });
    expect(regionOf(stack, ellipse(60, 45, 33, 22), phantom)?.minimum).toBe(-1000);
  });
  it("have the mean and the deviation of a ramp", () => {
    const [across, down, slopeX, slopeY] = [40.3, 25.3, 12, -31];
    const region = regionOf(
      stack,
      ellipse(60, 45, across, down),
      slice((x, y) => 40 + slopeX * (x - 60) + slopeY * (y - 45)),
    );
    expect(region?.mean).toBeCloseTo(40, 9); // by symmetry
    // The squares of the pixels inside lie between the ellipse shrunk and grown by s = sqrt(1/2) / 25.3: a pixel whose
    // centre is inside reaches at most sqrt(1/2) beyond the edge. So their number, and the integral of x² over them,
    // which is that of the centres plus 1/12 each, lie between those of the two ellipses.
    const s = Math.SQRT1_2 / Math.min(across, down);
    expect(region?.pixels).toBeGreaterThan(Math.PI * across * down * (1 - s) ** 2);
    expect(region?.pixels).toBeLessThan(Math.PI * across * down * (1 + s) ** 2);
    const deviation = (one: number, other: number) =>
      Math.hypot(
        slopeX * Math.sqrt(((across ** 2 / 4) * one ** 4) / other ** 2 - 1 / 12),
        slopeY * Math.sqrt(((down ** 2 / 4) * one ** 4) / other ** 2 - 1 / 12),
      );
    expect(region?.deviation).toBeGreaterThan(deviation(1 - s, 1 + s));
    expect(region?.deviation).toBeLessThan(deviation(1 + s, 1 - s));
  });
  it("cover the area of the ellipse in mm², with pixels that are not square", () => {
    expect(
      regionOf(
        stack,
        ellipse(60, 45, 40, 20),
        slice(() => 0),
      )?.area,
    ).toBeCloseTo(Math.PI * 20 * 25, 9);
  });
  it("end at the edge of the slice and of an oblique volume", () => {
    expect(
      regionOf(
        stack,
        ellipse(0, 45, 10, 2.5),
        slice((x) => x),
      )?.minimum,
    ).toBe(0);
    expect(
      regionOf(
        stack,
        ellipse(-50, 45, 10, 2),
        slice((x) => x),
      ),
    ).toBeNull();
    const half = slice((x) => x, { isInside: ({ x }) => x >= 0 }); // from column 60
    expect(regionOf(stack, ellipse(60, 45, 10, 5), half)).toMatchObject({ minimum: 60, maximum: 70 });
  });
  it("do not include what was cut away", () => {
    const cut = (clipped: boolean) => slice((x) => (x < 60 ? blank : 5), { clipped });
    expect(regionOf(stack, ellipse(60, 45, 10, 5), cut(true))).toMatchObject({ mean: 5, minimum: 5 });
    expect(regionOf(stack, ellipse(60, 45, 10, 5), cut(false))?.minimum).toBe(blank); // a voxel may have this value
  });
  it("do not exist in an ellipse without size", () => {
    expect(
      regionOf(
        stack,
        ellipse(60, 45, 0, 5),
        slice(() => 0),
      ),
    ).toBeNull();
  });
});
