import { signal } from "@preact/signals";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { vec3 } from "../input/vec3";
import { comingSlice, encodeSlices } from "../protocol/messages";
import { ClientMessageSchema, ExactSliceSchema } from "../protocol/gen/api/proto/stream_pb";
import { create, fromBinary } from "@bufbuild/protobuf";
import { curveFrom, CurveView, gridOf, noCurve } from "./curve_view";
import { slicesFromText, slicesToText } from "./memory";
import { Slices } from "./model";
import { noSlab } from "./oblique";
import type { WantedSlice } from "./store";
import { axial, coronal, header, sagittal } from "./testing";

const begun = () => new CurveView({ slab: signal(noSlab), spacing: () => 0.5 });

describe("the grid of a curved slice", () => {
  it("has square pixels of the smallest spacing and a row on the curve", () => {
    const { pixel, grid } = gridOf(100.2, 20, 0.5, noSlab);
    expect(pixel).toBe(0.5);
    expect([grid.columns, grid.rows]).toEqual([201, 41]);
    expect(grid.first.y).toBe(-10);
  });
  it("stays within the limits of the server", () => {
    for (const [long, height, mm] of [
      [5000, 20, 0],
      [10, 500, 0],
      [900, 500, 100],
    ] as const) {
      const spacing = 0.2;
      const { pixel, grid } = gridOf(long, height, spacing, { mm, projection: "mean" });
      const layers = mm > 0 ? 1 + Math.ceil(mm / spacing) : 1;
      expect(Math.max(grid.columns, grid.rows)).toBeLessThanOrEqual(2048);
      expect(grid.columns * grid.rows * layers).toBeLessThanOrEqual(2 ** 25);
      expect((grid.columns - 1) * pixel).toBeLessThanOrEqual(long + 1e-9);
    }
  });
});

describe("the view of a curve", () => {
  it("has a slice from two different points on, and takes back points", () => {
    const curve = begun();
    curve.add(vec3(-5, 0, 0));
    curve.add(vec3(-5, 0, 0)); // a double click
    expect(curve.points.value).toHaveLength(1);
    expect(curve.slice.value).toBeNull();
    curve.add(vec3(5, 0, 0));
    expect(curve.slice.value?.grid.columns).toBe(21);
    curve.undo();
    expect(curve.slice.value).toBeNull();
    curve.clear();
    expect(curve.points.value).toEqual([]);
  });
  it("takes at most 64 points", () => {
    const curve = begun();
    for (let i = 0; i < 70; ++i) curve.add(vec3(i, 0, 0));
    expect(curve.points.value).toHaveLength(64);
    expect(curve.full).toBe(true);
  });
  it("grabs and moves a point only in its slice", () => {
    const curve = begun();
    curve.add(vec3(0, 0, 0));
    curve.add(vec3(2, 1, 3));
    expect(curve.hold(axial, 2, vec3(0.2, 0, 0), 0.5)).toBe(true);
    curve.moveHeld(vec3(0, 1, 0));
    expect(curve.points.value).toEqual([vec3(0, 1, 0), vec3(2, 1, 3)]);
    expect(curve.hold(axial, 2, vec3(2, 1, 0), 5)).toBe(true); // the nearest in this slice is the other one
    expect(curve.held.value).toBe(0);
    expect(curve.hold(axial, 4, vec3(0, 1, 6), 9)).toBe(false);
  });
  it("tells where a pixel lies, also at an angle", () => {
    const curve = begun();
    curve.add(vec3(-5, 0, 0));
    curve.add(vec3(5, 0, 0));
    const slice = curve.slice.value ?? expect.unreachable();
    expect(curve.placeOf(slice, { column: 10, row: 60 })?.place.x).toBeCloseTo(0, 2);
    expect(curve.placeOf(slice, { column: 10, row: 64 })?.place.z).toBeCloseTo(-2, 9);
    curve.setAngle(90);
    const turned = curve.slice.value ?? expect.unreachable();
    expect(turned.id).not.toBe(slice.id);
    expect(curve.placeOf(turned, { column: 10, row: 64 })?.place.y).toBeCloseTo(2, 9);
  });
  it("keeps the pressed place when its pixels change", () => {
    const curve = begun();
    curve.add(vec3(-5, 0, 0));
    curve.add(vec3(5, 0, 0));
    const slice = curve.slice.value ?? expect.unreachable();
    expect(curve.cursor(slice)).toEqual({ column: 10, row: 60 });
    curve.choose(slice, { column: 4, row: 64 });
    curve.setHeight(20);
    expect(curve.cursor(curve.slice.value ?? slice)).toEqual({ column: 4, row: 24 });
  });
  it("is remembered, and a damaged one is none", () => {
    const curve = { points: [vec3(1, 2, 3)], angle: 12, height: 30 };
    expect(curveFrom(JSON.parse(JSON.stringify(curve)))).toEqual(curve);
    expect(curveFrom({ ...curve, angle: 999 }).angle).toBe(180);
    for (const damaged of [undefined, null, 7, { points: [1] }, { points: Array(65).fill(vec3(0, 0, 0)) }])
      expect(curveFrom(damaged)).toEqual(noCurve);
  });
});

describe("the slices with a curve", () => {
  let asked: (readonly WantedSlice[])[] = [];
  let frames: FrameRequestCallback[] = [];
  beforeEach(() => {
    asked = [];
    frames = [];
    vi.stubGlobal("requestAnimationFrame", (task: FrameRequestCallback) => frames.push(task));
  });
  afterEach(() => vi.unstubAllGlobals());
  const frame = () => {
    for (const task of frames.splice(0)) task(0);
    return asked.at(-1) ?? [];
  };
  const open = (before: ConstructorParameters<typeof Slices>[1] = null) => {
    const slices = new Slices((lacking) => asked.push(lacking), before);
    slices.configured([axial, sagittal, coronal], header);
    slices.allow("whole");
    slices.open.value = true;
    return slices;
  };
  const draw = ({ curve }: Slices) => {
    curve.add(vec3(-2, 0, 0));
    curve.add(vec3(2, 0, 3));
  };

  it("request the straightened slice beside the planes, as the server expects it", () => {
    const slices = open();
    draw(slices);
    slices.setSlab({ mm: 2, projection: "maximum" });
    const wanted = frame();
    expect(wanted.map(({ plane }) => plane)).toEqual(["axial", "sagittal", "coronal", "curve"]);
    const message = fromBinary(ClientMessageSchema, encodeSlices(wanted, 0n)).body;
    const at = message.case === "slices" ? message.value.slices[3] : undefined;
    expect(at?.plane).toBe(0);
    expect(at?.curved).toMatchObject({ columns: 6, rows: 61, pixel: 1, thickness: 2, projection: 1 });
    expect(at?.curved?.points.map(({ x, z }) => [x, z])).toEqual([
      [-2, 0],
      [2, 3],
    ]);
  });
  it("show it only to viewers who may choose their own slices", () => {
    const slices = open();
    expect(slices.curveShown.value).toBe(false);
    slices.tool.value = "curve";
    expect(slices.curveShown.value).toBe(true);
    slices.tool.value = "window";
    draw(slices);
    expect(slices.curveShown.value).toBe(true);
    slices.allow("shown");
    expect(slices.curveShown.value).toBe(false);
    expect(frame().some(({ plane }) => plane === "curve")).toBe(false);
    slices.allow("clipped");
    expect(slices.curveShown.value).toBe(true);
    slices.shown.value = "picture";
    expect(slices.curveShown.value).toBe(false);
  });
  it("keep the curve over a reload", () => {
    const slices = open();
    draw(slices);
    slices.curve.setAngle(40);
    const text = slicesToText(slices.remembered() ?? expect.unreachable());
    const again = open(slicesFromText(text));
    expect(again.curve.remembered()).toEqual(slices.curve.remembered());
  });
  it("recognise a curved slice that arrives", () => {
    const slice = create(ExactSliceSchema, { seq: 1n, curved: 7, columns: 2, rows: 1, data: new Uint8Array(4) });
    expect(comingSlice(slice)).toMatchObject({ plane: "curve", index: 0, oblique: 7, columns: 2 });
  });
});
