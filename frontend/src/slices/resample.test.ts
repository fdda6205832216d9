import { describe, expect, it } from "vitest";
import { interpolate, samplesOf } from "./resample";
import { blank } from "./stack";

/** Contains each value itself, to see what was interpolated. */
const identity = new Uint32Array(65536).map((_, bits) => bits);

function drawn(values: number[], columns: number, scale: readonly [number, number], size: readonly [number, number]) {
  const rows = values.length / columns;
  const across = samplesOf({ count: columns, start: 0, scale: scale[0], view: size[0] });
  const down = samplesOf({ count: rows, start: 0, scale: scale[1], view: size[1] });
  const into = new Uint32Array(across.left.length * down.left.length);
  interpolate(new Int16Array(values), columns, across, down, identity, into);
  return [...new Int16Array(into)];
}

describe("a smooth slice", () => {
  it("has the value of a pixel at its centre and a linear course in between", () => {
    // Five device pixels per pixel, so that the centres of 0 and 100 are the device pixels 2 and 7.
    expect(drawn([0, 100], 2, [5, 1], [10, 1])).toEqual([0, 0, 0, 20, 40, 60, 80, 100, 100, 100]);
    expect(drawn([0, 100], 1, [1, 5], [1, 10])).toEqual([0, 0, 0, 20, 40, 60, 80, 100, 100, 100]);
  });
  it("reproduces a plane exactly, with another scale along each axis", () => {
    const plane = (x: number, y: number) => 300 * x - 120 * y - 50;
    const values = [0, 1, 2].flatMap((y) => [0, 1, 2, 3].map((x) => plane(x, y)));
    const pixels = drawn(values, 4, [3, 5], [12, 15]);
    for (let y = 2; y < 13; ++y)
      for (let x = 1; x < 11; ++x)
        expect(pixels[12 * y + x]).toBe(Math.round(plane((x + 0.5) / 3 - 0.5, (y + 0.5) / 5 - 0.5)));
  });
  it("never leaves the range of the neighbouring values", () => {
    const pixels = drawn([-1000, -1000, 3000, 3000], 4, [7, 1], [28, 1]);
    expect([Math.min(...pixels), Math.max(...pixels)]).toEqual([-1000, 3000]);
  });
  it("shows no value between matter and what is cut away", () => {
    expect(new Set(drawn([blank, 60, 60, blank], 2, [9, 9], [18, 18]))).toEqual(new Set([blank, 60]));
  });
  it("covers the visible device pixels only", () => {
    const { left, part, start, size } = samplesOf({ count: 10, start: -30.25, scale: 10, view: 40 });
    expect([start, size]).toEqual([0, 40]);
    expect([left[0], left[39]]).toEqual([2, 6]);
    expect(part[0]).toBeCloseTo(0.575); // (0.5 + 30.25) / 10 - 0.5 is 2.575
  });
  it("takes each pixel once if the view is smaller", () => {
    const { left, part, start, size } = samplesOf({ count: 4, start: 3, scale: 0.5, view: 8 });
    expect([[...left], [...part], start, size]).toEqual([[0, 1, 2, 2], [0, 0, 0, 1], 3, 2]);
  });
});
