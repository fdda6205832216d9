import { describe, expect, it } from "vitest";
import { yuvToRgba } from "./yuv";

/** BT.601, studio range, as the standard writes it. */
function studio(r: number, g: number, b: number): [number, number, number] {
  const y = 0.299 * r + 0.587 * g + 0.114 * b;
  return [16 + (219 * y) / 255, 128 + (224 * (b - y)) / (255 * 1.772), 128 + (224 * (r - y)) / (255 * 1.402)];
}

describe("MPEG-1's colours", () => {
  it("are accurate within the rounding to whole levels", () => {
    // Half a level of luma is 0.58 of 255, half a level of a colour plane at most 1.01 (blue), and the result is rounded.
    const most = 0.58 + 1.01 + 0.5;
    for (const colour of [
      [200, 80, 40],
      [30, 120, 210],
      [0, 0, 0],
      [255, 255, 255],
      [255, 0, 0],
      [0, 0, 255],
      [128, 128, 128],
    ] as const) {
      const [y, cb, cr] = studio(colour[0], colour[1], colour[2]).map(Math.round);
      const out = new Uint8ClampedArray(4);
      yuvToRgba(
        new Uint8ClampedArray([y ?? 0]),
        new Uint8ClampedArray([cr ?? 0]),
        new Uint8ClampedArray([cb ?? 0]),
        2,
        1,
        1,
        out,
      );
      colour.forEach((level, n) => expect(Math.abs((out[n] ?? -99) - level)).toBeLessThanOrEqual(most));
      expect(out[3]).toBe(255);
    }
  });

  it("apply to four pixels each, from planes that are larger than the picture", () => {
    const stride = 16;
    const y = new Uint8ClampedArray(stride * 16).map((_, n) =>
      n % stride < 5 && n < 3 * stride ? 16 + 10 * Math.floor(n / stride) : 235,
    );
    const grey = new Uint8ClampedArray(64).fill(128);
    const red = grey.map((level, n) => (n === 8 + 2 ? 200 : level)); // the pixels (4..5, 2..3)
    const out = new Uint8ClampedArray(4 * 5 * 3);
    yuvToRgba(y, red, grey, stride, 5, 3, out);
    const at = (x: number, row: number) => [...out.slice(4 * (5 * row + x), 4 * (5 * row + x) + 3)];
    expect(at(0, 0)).toEqual([0, 0, 0]);
    expect(at(4, 1)).toEqual([12, 12, 12]);
    expect(at(3, 2)).toEqual([23, 23, 23]);
    expect(at(4, 2)[0]).toBeGreaterThan(100);
  });
});
