import { describe, expect, it } from "vitest";
import { labelPlaces, lineHeight, type Label } from "./label_places";

const area = { width: 400, height: 300 };
const at = (x: number, y: number, lines: readonly string[] = ["12.3 mm"]): Label => ({ lines, beside: [{ x, y }] });
const round = (x: number, y: number, size: number): Label => ({
  lines: ["Mean 40.0 HU, SD 12.0", "−3 to 88 HU", "2.0 cm², 420 pixels"],
  beside: [
    { x: x - size, y },
    { x: x + size, y },
    { x, y: y - size },
    { x, y: y + size },
  ],
});

describe("the labels of measurements", () => {
  it("stand on the right of what they belong to, and elsewhere at an edge of the slice", () => {
    expect(labelPlaces([at(100, 100)], area)).toEqual([{ x: 109, y: 91, anchor: "start" }]);
    expect(labelPlaces([at(390, 100)], area)).toEqual([{ x: 381, y: 91, anchor: "end" }]);
    const [top] = labelPlaces([at(100, 2)], area);
    expect(top?.y).toBeGreaterThanOrEqual(12);
    const [right, left] = [labelPlaces([round(60, 150, 40)], area), labelPlaces([round(340, 150, 40)], area)];
    expect([right[0]?.anchor, left[0]?.anchor]).toEqual(["start", "end"]);
    const [wide] = labelPlaces([round(200, 150, 85)], area);
    expect(wide).toMatchObject({ anchor: "middle" });
    expect(wide?.y, "above").toBeLessThan(65);
  });

  it("never cover each other while there is room", () => {
    const labels = [at(100, 100), at(104, 104), at(98, 96), at(110, 100), round(130, 110, 10), at(140, 110)];
    const boxes = labelPlaces(labels, area).map(({ x, y, anchor }, i) => {
      const lines = labels[i]?.lines ?? [];
      const width = 7.6 * Math.max(...lines.map((line) => line.length));
      const left = x - (anchor === "start" ? 0 : anchor === "end" ? width : width / 2);
      return { left, right: left + width, top: y - 12, bottom: y - 12 + lineHeight * lines.length };
    });
    boxes.forEach((a, i) => {
      expect(a.left >= 0 && a.right <= area.width && a.top >= 0 && a.bottom <= area.height).toBe(true);
      for (const b of boxes.slice(i + 1))
        expect(a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom).toBe(false);
    });
  });

  it("cover each other at last, when the slice is too small", () => {
    expect(labelPlaces([at(5, 5), at(6, 6), at(7, 7)], { width: 20, height: 20 })).toHaveLength(3);
    expect(labelPlaces([at(5, 5, [])], area)).toHaveLength(1);
  });
});
