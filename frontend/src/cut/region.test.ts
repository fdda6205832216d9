import { expect, test } from "vitest";
import { cross, dot, vec3 } from "../input/vec3";
import { dragged, handlePx, onScreen } from "../picture/project";
import {
  boundsOf,
  fromProposal,
  handles,
  handlesToTake,
  moved,
  partThatGoes,
  planeInRegion,
  placeOf,
  rangeOf,
  toBody,
  wholeRegion,
} from "./region";

const bounds = boundsOf({ size: [100, 200, 50], spacing: [1, 1, 4], direction: [1, 0, 0, 0, 1, 0, 0, 0, 1] });
const front = { eye: vec3(0, -500, 0), target: vec3(0, 0, 0), up: vec3(0, 0, 1), verticalFovDegrees: 30 };
const screen = { width: 800, height: 600 };

test("the bounds of a rotated volume contain all of it", () => {
  expect(bounds).toEqual({ low: vec3(-50, -100, -100), high: vec3(50, 100, 100) });
  const c = Math.SQRT1_2;
  const turned = boundsOf({ size: [100, 100, 10], spacing: [1, 1, 1], direction: [c, -c, 0, c, c, 0, 0, 0, 1] });
  expect(turned.high.x).toBeCloseTo(100 * c, 6);
  expect(turned.high.z).toBe(5);
});

test("the server's proposal is sent back unchanged", () => {
  const down = (50 * Math.PI) / 180;
  const normal = [0, -Math.cos(down), -Math.sin(down)];
  const region = fromProposal(
    { box: { low: [-50, -100, -100], high: [50, 100, 100] }, planes: [{ point: [3, -20, -30], normal }] },
    bounds,
  );
  expect(region.plane.tilt).toBeCloseTo(50, 9);
  const plane = toBody(region).planes?.[0];
  const side = (p: readonly number[]) => p.reduce((sum, v, i) => sum + v * (normal[i] ?? 0), 0);
  expect(side(plane?.point ?? [])).toBeCloseTo(side([3, -20, -30]), 9);
  expect(toBody(wholeRegion(bounds)).planes).toEqual([]);
});

test("a proposal for a turned head keeps its plane and is drawn in it", () => {
  const normal = [0.35, -0.75, -0.56].map((v, _, all) => v / Math.hypot(...all));
  const point = [12, -40, -25];
  const region = fromProposal(
    { box: { low: [-50, -100, -100], high: [50, 100, 100] }, planes: [{ point, normal }] },
    bounds,
  );
  const side = (p: readonly number[]) => p.reduce((sum, v, i) => sum + v * (normal[i] ?? 0), 0);
  const plane = toBody(region).planes?.[0];
  plane?.normal.forEach((v, i) => {
    expect(v).toBeCloseTo(normal[i] ?? 0, 9);
  });
  expect(side(plane?.point ?? [])).toBeCloseTo(side(point), 9);
  const polygon = planeInRegion(region);
  expect(polygon.length).toBeGreaterThanOrEqual(3);
  for (const p of polygon) expect(side([p.x, p.y, p.z])).toBeCloseTo(side(point), 6);
  // In order around: each turn goes the same way.
  const along = (i: number) => {
    const p = polygon[i % polygon.length] ?? vec3(0, 0, 0),
      q = polygon[(i + 1) % polygon.length] ?? vec3(0, 0, 0);
    return vec3(q.x - p.x, q.y - p.y, q.z - p.z);
  };
  const turns = polygon.map((_, i) =>
    Math.sign(dot(cross(along(i), along(i + 1)), vec3(normal[0] ?? 0, normal[1] ?? 0, normal[2] ?? 0))),
  );
  expect(new Set(turns).size).toBe(1);
});

test("no handle leaves the scan, and the box never closes", () => {
  for (const handle of handles) {
    for (const to of [-9999, 9999]) {
      const region = moved(handle, to, wholeRegion(bounds), bounds);
      for (const axis of ["x", "y", "z"] as const) {
        expect(region.low[axis]).toBeGreaterThanOrEqual(bounds.low[axis]);
        expect(region.high[axis]).toBeLessThanOrEqual(bounds.high[axis]);
        expect(region.high[axis] - region.low[axis]).toBeGreaterThanOrEqual(10);
      }
      const range = rangeOf(handle, region, bounds);
      expect(region.plane.offset).toBeGreaterThanOrEqual(-1000);
      expect(range.at).toBeGreaterThanOrEqual(range.low);
    }
  }
});

test("the centre is in the middle of the picture, the patient's left on its right, and the head above", () => {
  const middle = onScreen(front, screen, vec3(0, 0, 0));
  expect(middle?.x).toBeCloseTo(400, 6);
  expect(middle?.y).toBeCloseTo(300, 6);
  const left = onScreen(front, screen, vec3(10, 0, 0));
  const up = onScreen(front, screen, vec3(0, 0, 10));
  expect(left?.x).toBeGreaterThan(400);
  expect(up?.y).toBeLessThan(300);
  expect(onScreen(front, screen, vec3(0, -600, 0))).toBeNull();
});

test("a handle stays under the pointer that drags it", () => {
  const handle = { kind: "face", axis: "z", side: "high" } as const;
  const region = wholeRegion(bounds);
  const at = placeOf(handle, region);
  if (!at) throw new Error("no place");
  const by = dragged(front, screen, at.place, at.along, { x: 0, y: 40 }) ?? 0;
  const after = moved(handle, 100 + by, region, bounds);
  const beforePx = onScreen(front, screen, at.place),
    afterPx = onScreen(front, screen, placeOf(handle, after)?.place ?? at.place);
  expect((afterPx?.y ?? 0) - (beforePx?.y ?? 0)).toBeCloseTo(40, 3);
  // Towards the viewer no pixel means anything.
  const middle = placeOf({ kind: "face", axis: "y", side: "low" }, region);
  expect(middle && dragged(front, screen, middle.place, middle.along, { x: 5, y: 5 })).toBeNull();
});

test("the plane's polygon lies in the plane and in the box", () => {
  const region = { ...wholeRegion(bounds), plane: { on: true, tilt: 50, aside: 0, offset: 20 } };
  const points = planeInRegion(region);
  expect(points.length).toBe(4);
  for (const p of points) {
    expect(-Math.cos((50 * Math.PI) / 180) * p.y - Math.sin((50 * Math.PI) / 180) * p.z).toBeCloseTo(20, 6);
    expect(Math.abs(p.x)).toBeLessThanOrEqual(50);
  }
  expect(planeInRegion({ ...region, plane: { ...region.plane, offset: 999 } })).toEqual([]);
});

test("the removed share is estimated approximately", () => {
  expect(partThatGoes(wholeRegion(bounds), bounds)).toBe(0);
  expect(
    partThatGoes(moved({ kind: "face", axis: "z", side: "high" }, 0, wholeRegion(bounds), bounds), bounds),
  ).toBeCloseTo(0.5, 6);
  expect(
    partThatGoes({ ...wholeRegion(bounds), plane: { on: true, tilt: 0, aside: 0, offset: 0 } }, bounds),
  ).toBeCloseTo(0.5, 6);
});

test("of overlapping handles only one is shown: the dragged one, then the plane's, then the nearest", () => {
  const box = wholeRegion(bounds),
    cut = { ...box, plane: { ...box.plane, on: true, tilt: 0, offset: 100 - 1 } };
  const names = (region: typeof box, held: (typeof handles)[number] | null = null) =>
    handlesToTake(front, screen, region, held).map(({ handle }) =>
      handle.kind === "plane" ? "plane" : `${handle.axis}-${handle.side}`,
    );
  const back = handles.find((h) => h.kind === "face" && h.axis === "y" && h.side === "high") ?? null;
  expect(names(box)).toEqual(["x-low", "x-high", "y-low", "z-low", "z-high"]);
  expect(names(box, back)).toEqual(["x-low", "x-high", "y-high", "z-low", "z-high"]);
  expect(names(cut)).toEqual(["x-low", "x-high", "z-low", "z-high", "plane"]);
  // Whichever way the head is turned.
  for (let turn = 0; turn < 360; turn += 7) {
    const eye = vec3(500 * Math.sin((turn * Math.PI) / 180), -500 * Math.cos((turn * Math.PI) / 180), 90);
    const taken = handlesToTake({ ...front, eye }, screen, cut, back);
    expect(taken.some(({ handle }) => handle === back)).toBe(true);
    for (const a of taken)
      for (const b of taken) if (a !== b) expect(Math.hypot(a.x - b.x, a.y - b.y)).toBeGreaterThanOrEqual(handlePx);
  }
});
