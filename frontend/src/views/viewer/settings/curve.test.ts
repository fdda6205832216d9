import { describe, expect, it } from "vitest";
import { channels_of, shown_range, transfer_of } from "../../../scene/transfer";
import { some_scene } from "../../../scene/testing";
import { area_of, graph_width, nearest_point, opacity_of, points_of, value_at, x_of, y_of } from "./curve";

const range = shown_range(transfer_of(some_scene()), -1024, 3071);

describe("the graph", () => {
  it("a place on it is a value and an opacity, there and back", () => {
    for (const value of [-1024, 0, 55.5, 3072]) expect(value_at(x_of(value, range), range)).toBeCloseTo(value, 6);
    for (const opacity of [0, 0.25, 1]) expect(opacity_of(y_of(opacity))).toBeCloseTo(opacity, 9);
    expect([opacity_of(-50), opacity_of(1e4)]).toEqual([1, 0]);
  });

  it("a finger takes the nearest point, and none where there is none", () => {
    const points = [{ x: 10, y: 10 }, { x: 20, y: 10 }, { x: 20, y: 10 }];
    expect(nearest_point(points, { x: 12, y: 11 }, 16)).toBe(0);
    expect(nearest_point(points, { x: 19, y: 10 }, 16)).toBe(2);
    expect(nearest_point(points, { x: 60, y: 60 }, 16)).toBeNull();
  });

  it("a channel is closed at both of its ends", () => {
    const [, bone] = channels_of(some_scene());
    if (!bone) throw new Error("no channel");
    const corners = area_of(bone, range).split(" ");
    expect(corners.length).toBe(bone.opacity.length + 2);
    expect(corners.at(-1)).toBe(`${points_of(bone, range).at(-1)?.x.toFixed(1)},${y_of(0).toFixed(1)}`);
    expect(Number(corners.at(-1)?.split(",")[0])).toBeLessThanOrEqual(graph_width);
  });
});
