import { describe, expect, it } from "vitest";
import { SliceGestures, Wheel } from "./slice_gestures";
import type { PointerSample } from "../input/pointer_sample";

const at = (x: number, y: number, more: Partial<PointerSample> = {}): PointerSample => ({
  id: 1,
  x,
  y,
  touch: false,
  button: 0,
  shift: false,
  ctrl: false,
  ...more,
});
const finger = (id: number, x: number, y: number) => at(x, y, { id, touch: true });

describe("gestures on a slice", () => {
  it("use the tool from where the drag began, or tap", () => {
    const gestures = new SliceGestures();
    expect(gestures.down(at(10, 10))).toEqual([]);
    expect(gestures.move(at(12, 10))).toEqual([]);
    expect(gestures.move(at(20, 10))).toEqual([
      { kind: "begin", at: { x: 10, y: 10 } },
      { kind: "drag", from: { x: 10, y: 10 }, at: { x: 20, y: 10 }, by: { x: 10, y: 0 } },
    ]);
    expect(gestures.move(at(20, 15))).toMatchObject([{ kind: "drag", by: { x: 0, y: 5 } }]);
    expect(gestures.up(1)).toEqual([]);
    gestures.down(at(30, 30));
    gestures.move(at(31, 31));
    expect(gestures.up(1)).toMatchObject([{ kind: "tap" }]);
  });
  it("with Shift move the crosshair, and without it only report the pointer", () => {
    const gestures = new SliceGestures();
    expect(gestures.move(at(5, 6, { shift: true }))).toEqual([{ kind: "cross", at: { x: 5, y: 6 } }]);
    expect(gestures.move(at(7, 8))).toEqual([]);
    expect(gestures.down(at(7, 8, { shift: true }))).toEqual([{ kind: "cross", at: { x: 7, y: 8 } }]);
    expect(gestures.move(at(9, 8))).toEqual([{ kind: "cross", at: { x: 9, y: 8 } }]);
  });
  it("pan with the middle button and zoom with the right one", () => {
    const gestures = new SliceGestures();
    gestures.down(at(0, 0, { button: 1 }));
    expect(gestures.move(at(3, -2))).toEqual([{ kind: "pan", by: { x: 3, y: -2 } }]);
    gestures.up(1);
    gestures.down(at(50, 50, { button: 2 }));
    const [zoom] = gestures.move(at(50, 20));
    expect(zoom?.kind === "zoom" && zoom.factor).toBeGreaterThan(1);
  });
  it("with two fingers pan and zoom, without using the tool before or after", () => {
    const gestures = new SliceGestures();
    gestures.down(finger(1, 100, 100));
    gestures.down(finger(2, 200, 100));
    expect(gestures.move(finger(2, 300, 100))).toEqual([
      { kind: "pan", by: { x: 50, y: 0 } },
      { kind: "zoom", factor: 2, at: { x: 200, y: 100 } },
    ]);
    expect(gestures.up(2)).toEqual([]);
    expect(gestures.move(finger(1, 150, 150))).toEqual([]);
    expect(gestures.up(1)).toEqual([]);
  });
  it("with three fingers scroll one slice per 12 pixels", () => {
    const gestures = new SliceGestures();
    for (const id of [1, 2, 3]) gestures.down(finger(id, 100 * id, 100));
    const actions = [1, 2, 3].flatMap((id) => gestures.move(finger(id, 100 * id, 130)));
    expect(actions).toEqual([
      { kind: "scroll", slices: 1 },
      { kind: "scroll", slices: 1 },
    ]);
  });
});

describe("a wheel", () => {
  it("scrolls one slice per step in any unit, and adds up small steps", () => {
    const wheel = new Wheel();
    expect([wheel.slices(3, 1), wheel.slices(-1, 2), wheel.slices(120, 0), wheel.slices(1e9, 0)]).toEqual([
      1, -1, 1, 1,
    ]);
    const pad = new Wheel();
    expect([10, 10, 10, 10, 10].map((step) => pad.slices(step, 0))).toEqual([0, 0, 1, 0, 0]);
    expect(pad.slices(-20, 0)).toBe(0);
    expect(pad.slices(-10, 0)).toBe(-1);
  });
});
