import { describe, expect, it } from "vitest";
import { vec3 } from "../input/vec3";
import { wholeSlice } from "../slices/placing";
import type { Stack } from "../slices/stack";
import { newMark, type Mark } from "./mark";
import { shapesOf } from "./shapes";
import { nearMm, viewOfPicture, viewOfSlice } from "./view";

const screen = { x: 20, y: 0, width: 400, height: 400 };
const eye = { eye: vec3(0, -100, 0), target: vec3(0, 0, 0), up: vec3(0, 0, 1), verticalFovDegrees: 90 };
const mark = (kind: Mark["kind"], more: Partial<Mark> = {}): Mark => ({
  ...newMark(kind, vec3(0, 0, 0), 0),
  id: 1,
  ...more,
});

describe("a mark in the picture", () => {
  const view = viewOfPicture(eye, screen, new Set(["0.1"]));

  it("is at its point of the scan, and as large as it is there", () => {
    expect(view.pointOf(vec3(0, 0, 0))).toEqual({ x: 220, y: 200 });
    expect(view.radiusOf(vec3(0, 0, 0), 10)).toBeCloseTo(20);
    const moved = view.beside(vec3(0, 0, 0), { x: 20, y: 0 });
    expect(view.pointOf(moved)?.x).toBeCloseTo(240);
  });

  it("is faint while it lies behind matter", () => {
    expect(view.lookOf(mark("text"), "0.1")).toBe("faint");
    expect(view.lookOf(mark("text"), "1.1"), "of someone else").toBe("plain");
  });

  it("keeps a direction and a length if it points away from the viewer", () => {
    const shapes = shapesOf(mark("arrow", { tail: vec3(0, 30, 0) }), view, screen);
    const [from, to] = shapes?.lines[0] ?? [];
    expect(Math.hypot((from?.x ?? 0) - 220, (from?.y ?? 0) - 200)).toBeGreaterThan(10);
    expect(to).not.toEqual(from);
  });

  it("is not drawn behind the eye", () => {
    expect(shapesOf(mark("text", { place: vec3(0, -200, 0) }), view, screen)).toBeNull();
  });
});

describe("a mark in a slice", () => {
  const stack: Stack = {
    plane: "axial",
    columns: 100,
    rows: 100,
    slices: 50,
    first: vec3(-50, -50, -50),
    right: vec3(1, 0, 0),
    down: vec3(0, 1, 0),
    next: vec3(0, 0, 2),
  };
  const area = { width: 200, height: 200 };
  const view = (index: number) => viewOfSlice(stack, wholeSlice(stack), area, index);

  it("appears on its slice, faintly near it, and not elsewhere", () => {
    const text = mark("text", { place: vec3(0, 0, 0) }); // slice 25
    expect(view(25).lookOf(text, "")).toBe("plain");
    expect(view(26).lookOf(text, "")).toBe("faint");
    expect(view(25 + nearMm).lookOf(text, "")).toBe("none");
  });

  it("is the section of its sphere", () => {
    const circle = mark("circle", { radius: 10 });
    const whole = view(25).radiusOf(circle.place, 10);
    expect(view(29).lookOf(circle, "")).toBe("plain");
    expect(view(29).radiusOf(circle.place, 10)).toBeCloseTo(whole * Math.sqrt(1 - 0.7 ** 2));
  });

  it("moves within the slice", () => {
    const from = view(25).pointOf(vec3(0, 0, 0));
    const moved = view(25).beside(vec3(0, 0, 0), { x: 20, y: -10 });
    expect(moved.z).toBe(0);
    expect(view(25).pointOf(moved)?.x).toBeCloseTo((from?.x ?? 0) + 20);
    expect(view(25).pointOf(moved)?.y).toBeCloseTo((from?.y ?? 0) - 10);
  });
});
