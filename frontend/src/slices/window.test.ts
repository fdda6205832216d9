import { describe, expect, it } from "vitest";
import { bounded, dragged, firstWindow, greyOf, shade, tableOf } from "./window";

const window = { centre: 40, width: 400 };

describe("a window", () => {
  it("maps values below it to black, above it to white, and linearly between", () => {
    expect([-5000, -160, -60, 40, 140, 240, 5000].map((value) => greyOf(value, window))).toEqual([
      0, 0, 64, 128, 191, 255, 255,
    ]);
  });
  it("gives the same result in its table as in its formula, for every value", () => {
    const table = tableOf(window);
    const wrong = Array.from({ length: 65536 }, (_, i) => i - 32768).filter(
      (value) => table[value & 0xffff] !== ((255 << 24) | (greyOf(value, window) * 0x10101)) >>> 0,
    );
    expect(wrong).toEqual([]);
    const pixels = new Uint32Array(3);
    shade(new Int16Array([-32768, 40, 32767]), table, pixels);
    expect([...pixels]).toEqual([0xff000000, 0xff808080, 0xffffffff]);
  });
  it("widens when dragged to the right, moves down when dragged down, and stays valid", () => {
    expect(dragged(window, 0.1, 0.2, 1000)).toEqual({ centre: -160, width: 500 });
    expect(dragged(window, -9, 0, 1000).width).toBe(1);
    expect(bounded({ centre: 1e9, width: 1e9 })).toEqual({ centre: 32767, width: 65535 });
  });
  it("starts with the scan's own values, or else covers nearly all values", () => {
    const header = {
      windowCenter: 50,
      windowWidth: 300,
      minimum: -1000,
      maximum: 3000,
      percentiles: [-900, 0, 1, 2, 3, 4, 1100, 2000],
    };
    expect(firstWindow(header)).toEqual({ centre: 50, width: 300 });
    expect(firstWindow({ ...header, windowWidth: 0 })).toEqual({ centre: 100, width: 2000 });
    expect(firstWindow({ windowCenter: 0, windowWidth: 0, minimum: 7, maximum: 7, percentiles: [] })).toEqual({
      centre: 7,
      width: 1,
    });
  });
});
