import { describe, expect, it } from "vitest";
import { channelsOf, shownRange, transferOf } from "../../../scene/transfer";
import { someScene } from "../../../scene/testing";
import { areaOf, graphWidth, nearestPoint, opacityOf, pointsOf, valueAt, xOf, yOf } from "./curve";

const range = shownRange(transferOf(someScene()), -1024, 3071);

describe("the graph", () => {
  it("maps a point to a value and an opacity, and back", () => {
    for (const value of [-1024, 0, 55.5, 3072]) expect(valueAt(xOf(value, range), range)).toBeCloseTo(value, 6);
    for (const opacity of [0, 0.25, 1]) expect(opacityOf(yOf(opacity))).toBeCloseTo(opacity, 9);
    expect([opacityOf(-50), opacityOf(1e4)]).toEqual([1, 0]);
  });

  it("finds the point nearest to a finger, or none", () => {
    const points = [
      { x: 10, y: 10 },
      { x: 20, y: 10 },
      { x: 20, y: 10 },
    ];
    expect(nearestPoint(points, { x: 12, y: 11 }, 16)).toBe(0);
    expect(nearestPoint(points, { x: 19, y: 10 }, 16)).toBe(2);
    expect(nearestPoint(points, { x: 60, y: 60 }, 16)).toBeNull();
  });

  it("closes a channel at both ends", () => {
    const [, bone] = channelsOf(someScene());
    if (!bone) throw new Error("no channel");
    const corners = areaOf(bone, range).split(" ");
    expect(corners.length).toBe(bone.opacity.length + 2);
    expect(corners.at(-1)).toBe(`${pointsOf(bone, range).at(-1)?.x.toFixed(1)},${yOf(0).toFixed(1)}`);
    expect(Number(corners.at(-1)?.split(",")[0])).toBeLessThanOrEqual(graphWidth);
  });
});
