import { describe, expect, it } from "vitest";
import { panned, perMm, pixelAt, pointOf, wholeSlice, zoomed } from "./placing";
import { axial } from "./testing";

const area = { width: 600, height: 800 };
const whole = wholeSlice(axial);

describe("a slice in its view", () => {
  it("is complete and centred, with square millimetres", () => {
    expect(perMm(axial, whole, area)).toBeCloseTo(94); // 6 mm of 600
    expect(pointOf(axial, whole, area, { column: 2.5, row: 1.5 })).toEqual({ x: 300, y: 400 });
    const corner = pointOf(axial, whole, area, { column: -0.5, row: -0.5 });
    expect(corner.x).toBeCloseTo(300 - 3 * 94);
    expect(corner.y).toBeCloseTo(400 - 4 * 94);
  });
  it("maps a point of the view to the pixel shown there", () => {
    const placing = { zoom: 3, column: 1, row: 2 };
    const at = pointOf(axial, placing, area, { column: 4.25, row: 0.75 });
    expect(pixelAt(axial, placing, area, at)).toEqual({ column: 4.25, row: 0.75 });
  });
  it("keeps the point under the pointer while zooming", () => {
    const at = { x: 200, y: 500 };
    const before = pixelAt(axial, whole, area, at);
    const nearer = pixelAt(axial, zoomed(axial, whole, area, 2.5, at), area, at);
    expect(nearer.column).toBeCloseTo(before.column);
    expect(nearer.row).toBeCloseTo(before.row);
    const moved = pixelAt(axial, panned(axial, whole, area, 50, -30), area, { x: 250, y: 470 });
    expect(moved.column).toBeCloseTo(before.column);
    expect(moved.row).toBeCloseTo(before.row);
  });
  it("cannot be moved out of its view", () => {
    expect(panned(axial, whole, area, 1e5, -1e5)).toEqual({ zoom: 1, column: 0, row: 3 });
    expect(zoomed(axial, whole, area, 1e9, { x: 0, y: 0 }).zoom).toBe(40);
    expect(Number.isFinite(perMm(axial, whole, { width: 0, height: 0 }))).toBe(true);
  });
});
