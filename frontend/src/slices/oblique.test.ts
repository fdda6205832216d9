import { describe, expect, it } from "vitest";
import { cross, dot, length, vec3, type Vec3 } from "../input/vec3";
import { isInSlice, withCorner, type Measure } from "./measure";
import {
  normalOf,
  obliqueStack,
  slabFrom,
  straightTilt,
  tiltDegrees,
  tiltFrom,
  traceOf,
  turned,
  type Tilt,
} from "./oblique";
import { perMm } from "./placing";
import { edgesOf, placeOf, planes, spotOf, type Stack } from "./stack";
import { axial, coronal, sagittal } from "./testing";

const stacks = new Map([axial, sagittal, coronal].map((stack) => [stack.plane, stack]));
const straight = straightTilt(stacks) ?? expect.unreachable();
const thin = { mm: 0, projection: "mean" } as const;
const oblique = (stack: Stack, tilt: Tilt, slab: { mm: number; projection: "mean" } = thin) =>
  obliqueStack({ straight: stack, axes: tilt[stack.plane], slab, spacing: 1, id: 7 });
const near = (a: Vec3, b: Vec3) => {
  for (const axis of ["x", "y", "z"] as const) expect(a[axis]).toBeCloseTo(b[axis], 9);
};

describe("tilted planes", () => {
  it("turn about the normal of the plane in whose view they are turned", () => {
    const tilt = turned(straight, "axial", Math.PI / 6);
    expect(tilt.axial).toEqual(straight.axial);
    // Clockwise in the axial view, whose x points right and y down.
    near(tilt.coronal.right, vec3(Math.cos(Math.PI / 6), Math.sin(Math.PI / 6), 0));
    near(tilt.coronal.down, vec3(0, 0, -1));
    expect(tiltDegrees(tilt.coronal, straight.coronal)).toBeCloseTo(30);
  });

  it("stay perpendicular to each other after many turns", () => {
    let tilt = straight;
    for (let i = 0; i < 3000; ++i) tilt = turned(tilt, planes[i % 3] ?? "axial", 0.37);
    for (const plane of planes) {
      const { right, down } = tilt[plane];
      expect(length(right)).toBeCloseTo(1, 12);
      expect(dot(right, down)).toBeCloseTo(0, 12);
      for (const other of planes) {
        if (other !== plane) expect(dot(normalOf(tilt[plane]), normalOf(tilt[other]))).toBeCloseTo(0, 9);
      }
    }
  });

  it("cover the whole volume in square pixels, centred at its centre", () => {
    const stack = oblique(sagittal, turned(straight, "axial", 0.3));
    expect(length(stack.right)).toBeCloseTo(1);
    expect(length(stack.down)).toBeCloseTo(1);
    near(
      placeOf(stack, { column: (stack.columns - 1) / 2, row: (stack.rows - 1) / 2, slice: (stack.slices - 1) / 2 }),
      vec3(0, 0, 0),
    );
    for (const x of [-3, 3])
      for (const y of [-4, 4])
        for (const z of [-7.5, 7.5]) {
          const spot = spotOf(stack, vec3(x, y, z));
          expect(spot.column).toBeGreaterThanOrEqual(-0.5);
          expect(spot.column).toBeLessThanOrEqual(stack.columns - 0.5);
          expect(spot.row).toBeLessThanOrEqual(stack.rows - 0.5);
          expect(spot.slice).toBeGreaterThanOrEqual(-0.5);
          expect(spot.slice).toBeLessThanOrEqual(stack.slices - 0.5);
        }
  });

  it("scroll in the direction of the server's stack", () => {
    for (const stack of [axial, sagittal, coronal]) {
      expect(dot(oblique(stack, straight).next, stack.next)).toBeGreaterThan(0);
    }
  });

  it("keep the scale of the straight slice at any angle", () => {
    const area = { width: 400, height: 300 };
    const placing = { zoom: 1, column: 0, row: 0 };
    for (const angle of [0, 0.4, 1.2]) {
      const stack = oblique(coronal, turned(straight, "axial", angle));
      expect(perMm(stack, placing, area)).toBeCloseTo(perMm(coronal, placing, area));
    }
  });

  it("have larger pixels where a thick slab would need too many samples", () => {
    const large: Stack = {
      ...axial,
      columns: 512,
      rows: 512,
      slices: 400,
      right: vec3(0.7, 0, 0),
      down: vec3(0, 0.7, 0),
      next: vec3(0, 0, 0.7),
    };
    const slab = { mm: 100, projection: "mean" } as const;
    const stack = obliqueStack({ straight: large, axes: straight.axial, slab, spacing: 0.7, id: 1 });
    const layers = 1 + Math.ceil(100 / 0.7);
    expect(stack.columns * stack.rows * layers).toBeLessThanOrEqual(2 ** 25);
    expect(stack.columns * length(stack.right)).toBeGreaterThanOrEqual(0.7 * Math.hypot(512, 512, 400) - 1e-9);
  });

  it("cross each other in lines, and name the sides that they lie between", () => {
    const tilt = turned(straight, "axial", Math.PI / 4);
    const line = traceOf(axial, oblique(coronal, tilt));
    expect(Math.abs(line.x)).toBeCloseTo(Math.SQRT1_2);
    expect(line.x * line.y).toBeGreaterThan(0);
    expect(traceOf(axial, coronal)).toMatchObject({ y: expect.closeTo(0) as number });
    expect(edgesOf(oblique(coronal, tilt)).right).toMatch(/^(LP|PL)$/);
    expect(edgesOf(coronal)).toEqual({ right: "L", left: "R", top: "S", bottom: "I" });
  });

  it("are forgotten if what the browser stored is damaged", () => {
    expect(tiltFrom(JSON.parse(JSON.stringify(straight)))).toEqual(straight);
    expect(tiltFrom({ ...straight, axial: { right: vec3(1, 0, 0) } })).toBeNull();
    expect(tiltFrom(undefined)).toBeNull();
    expect(slabFrom({ mm: 1e9, projection: "median" })).toEqual({ mm: 100, projection: "mean" });
  });
});

describe("a measurement in an oblique slice", () => {
  const tilt = turned(turned(straight, "axial", 0.5), "sagittal", 0.3);
  const stack = oblique(coronal, tilt);
  const index = (stack.slices - 1) / 2;
  const at = (column: number, row: number, slice = index) => placeOf(stack, { column, row, slice });

  it("is shown in each slice that contains it", () => {
    const ruler: Measure = { kind: "ruler", plane: null, slice: 0, points: [at(1, 1), at(4, 3)] };
    expect(isInSlice(ruler, stack, index)).toBe(true);
    expect(isInSlice(ruler, stack, index + 1)).toBe(false);
    const other = oblique(axial, tilt);
    expect(isInSlice(ruler, other, 3)).toBe(false);
    const thick = oblique(coronal, tilt, { mm: 4, projection: "mean" });
    expect(isInSlice(ruler, thick, (thick.slices - 1) / 2 + 2), "2 mm away in a slab of 4 mm").toBe(true);
  });

  it("of a region belongs to slices of its direction", () => {
    const ellipse = withCorner(stack, { kind: "ellipse", plane: null, slice: 0, points: [at(1, 1), at(6, 4)] });
    expect(spotOf(stack, ellipse.corner ?? vec3(0, 0, 0))).toMatchObject({
      column: expect.closeTo(1) as number,
      row: expect.closeTo(4) as number,
    });
    expect(isInSlice(ellipse, stack, index)).toBe(true);
    // The same plane, turned within itself.
    const axes = { right: tilt.coronal.down, down: cross(normalOf(tilt.coronal), tilt.coronal.down) };
    const spun = obliqueStack({ straight: coronal, axes, slab: thin, spacing: 1, id: 8 });
    expect(Math.abs(dot(spun.next, stack.next))).toBeCloseTo(1);
    expect(isInSlice(ellipse, spun, (spun.slices - 1) / 2)).toBe(false);
  });

  it("that was made in a stored slice is not mixed up with an oblique one of the same number", () => {
    const ruler: Measure = { kind: "ruler", plane: "coronal", slice: index, points: [vec3(-2, -3, 0), vec3(2, -3, 1)] };
    expect(isInSlice(ruler, stack, index)).toBe(false);
    expect(isInSlice(ruler, coronal, index)).toBe(true);
  });
});
