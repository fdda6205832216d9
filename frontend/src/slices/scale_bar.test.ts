import { describe, expect, it } from "vitest";
import { perMm, pointOf, wholeSlice } from "./placing";
import { scaleBar } from "./scale_bar";
import { axial, coronal } from "./testing";

describe("the scale bar", () => {
  it("is the longest round length that fits", () => {
    const mm = [0.11, 0.9, 2, 7, 10, 23, 61, 99, 160, 4000].map((limit) => scaleBar(2, 2 * limit).mm);
    expect(mm).toEqual([0.1, 0.5, 2, 5, 10, 20, 50, 50, 100, 2000]);
  });
  it("is as long as that length in the slice, in every direction of anisotropic voxels and at every zoom", () => {
    const area = { width: 600, height: 400 };
    for (const stack of [axial, coronal]) {
      for (const zoom of [0.5, 1, 7.3]) {
        const placing = { ...wholeSlice(stack), zoom };
        const { mm, pixels } = scaleBar(perMm(stack, placing, area), 120);
        expect(pixels).toBeLessThanOrEqual(120);
        const at = (column: number, row: number) => pointOf(stack, placing, area, { column, row });
        expect(at(mm / Math.hypot(stack.right.x, stack.right.y, stack.right.z), 0).x - at(0, 0).x).toBeCloseTo(pixels);
        expect(at(0, mm / Math.hypot(stack.down.x, stack.down.y, stack.down.z)).y - at(0, 0).y).toBeCloseTo(pixels);
      }
    }
  });
});
