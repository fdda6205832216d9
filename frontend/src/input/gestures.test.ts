import { describe, expect, it } from "vitest";
import { Gestures, wheelZoom } from "./gestures";
import type { PointerSample } from "./pointer_sample";
import { commandOf, type Focused } from "./keys";

const area = { width: 800, height: 400 };
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
const drag = (more: Partial<PointerSample>, to = at(140, 120)) => {
  const gestures = new Gestures();
  gestures.down(at(100, 100, more));
  return gestures.move({ ...to, ...more }, area);
};

describe("the mouse", () => {
  it("rotates with the left button, half a turn for the height of the picture", () => {
    expect(drag({})).toEqual([{ kind: "rotate", right: Math.PI / 10, down: Math.PI / 20 }]);
  });
  it("pans with the middle button or Shift and the left one", () => {
    for (const more of [{ button: 1 }, { shift: true }])
      expect(drag(more)).toEqual([{ kind: "pan", right: 0.1, down: 0.05 }]);
  });
  it("zooms with the right button, upwards to zoom in", () => {
    const [up] = drag({ button: 2 }, at(100, 50));
    expect(up?.kind === "zoom" && up.factor).toBeGreaterThan(1);
  });
  it("rolls about the middle with Ctrl and the left button, by the shorter way", () => {
    const gestures = new Gestures();
    gestures.down(at(100, 201, { ctrl: true }));
    const [roll] = gestures.move(at(100, 199, { ctrl: true }), area);
    expect(roll?.kind).toBe("roll");
    if (roll?.kind === "roll") expect(roll.angle).toBeCloseTo(2 / 300, 4);
  });
  it("keeps the gesture that a drag began with, and does nothing without a button", () => {
    const gestures = new Gestures();
    gestures.down(at(0, 0, { shift: true }));
    expect(gestures.move(at(10, 0), area)[0]?.kind).toBe("pan");
    gestures.up(1);
    expect(gestures.move(at(20, 0), area)).toEqual([]);
  });
  it("reports the same position only once", () => {
    const gestures = new Gestures();
    gestures.down(at(0, 0));
    expect(gestures.move(at(10, 0), area)).toHaveLength(1);
    expect(gestures.move(at(10, 0), area)).toEqual([]);
  });
  it("zooms back to the same size with the wheel in any unit, and never by too much at once", () => {
    expect(wheelZoom(-120, 0, false) * wheelZoom(120, 0, false)).toBeCloseTo(1, 12);
    expect(wheelZoom(-3, 1, false)).toBeGreaterThan(1);
    expect(wheelZoom(-1e9, 0, false)).toBeLessThan(2);
  });
});

describe("touch", () => {
  it("rotates with one finger", () => {
    expect(drag({ touch: true })[0]?.kind).toBe("rotate");
  });
  it("zooms and pans with two fingers", () => {
    const gestures = new Gestures();
    gestures.down(at(100, 200, { touch: true }));
    gestures.down(at(300, 200, { touch: true, id: 2 }));
    expect(gestures.move(at(500, 200, { touch: true, id: 2 }), area)).toEqual([
      { kind: "pan", right: 0.25, down: 0 },
      { kind: "zoom", factor: 2 },
    ]);
  });
  it("stops with a third finger", () => {
    const gestures = new Gestures();
    for (const id of [1, 2, 3]) gestures.down(at(100 * id, 200, { touch: true, id }));
    expect(gestures.move(at(350, 200, { touch: true, id: 3 }), area)).toEqual([]);
  });
});

describe("the keys", () => {
  const press = (key: string, more = {}, focused: Focused = "none") =>
    commandOf({ key, shift: false, ctrl: false, alt: false, meta: false, ...more }, focused);
  it("run the documented commands", () => {
    expect(press("ArrowLeft")).toMatchObject({ gesture: { kind: "rotate", down: 0 } });
    expect(press("ArrowUp", { shift: true })).toMatchObject({ gesture: { kind: "pan", right: 0, down: -0.03 } });
    expect(press("ArrowRight", { ctrl: true })).toMatchObject({ gesture: { kind: "roll" } });
    expect(press("+")).toMatchObject({ gesture: { kind: "zoom", factor: 1.12 } });
    expect(["r", "3", "f", "S", "?"].map((key) => press(key)?.kind)).toEqual([
      "reset",
      "preset",
      "fullscreen",
      "screenshot",
      "help",
    ]);
    expect(press("7")).toEqual({ kind: "preset", index: 6 });
  });
  it("turn to the side whose letter is on the cube, with Shift", () => {
    for (const letter of ["A", "P", "L", "R", "S", "I"])
      expect(press(letter, { shift: true })).toEqual({ kind: "side", letter });
    // Caps Lock is not Shift.
    expect(["R", "S", "P", "t", "T"].map((key) => press(key)?.kind)).toEqual([
      "reset",
      "screenshot",
      "pause",
      "tour",
      "tour",
    ]);
    expect(press("A", { shift: true, ctrl: true })).toBeNull();
  });
  it("leave text fields all keys, and radio buttons all but those of the views", () => {
    expect([press("v")?.kind, press("M")?.kind, press("v", { ctrl: true })]).toEqual(["slices", "alone", null]);
    expect(["v", "m", "ArrowLeft", "3", "r"].map((key) => press(key, {}, "choice")?.kind)).toEqual([
      "slices",
      "alone",
      undefined,
      undefined,
      undefined,
    ]);
    for (const focused of ["text", "list"] as const)
      expect(["v", "m", "ArrowLeft", "3", "r"].map((key) => press(key, {}, focused))).toEqual([
        null,
        null,
        null,
        null,
        null,
      ]);
  });
  it("leave the browser its shortcuts", () => {
    for (const [key, more] of [
      ["r", { ctrl: true }],
      ["s", { meta: true }],
      ["ArrowLeft", { alt: true }],
      ["8", {}],
      ["Tab", {}],
    ] as const)
      expect(press(key, more)).toBeNull();
  });
});
