import { describe, expect, it } from "vitest";
import { dot, length, subtract, vec3 } from "../input/vec3";
import { withCamera } from "../protocol/messages";
import type { Scene } from "../protocol/gen/api/proto/scene_pb";
import { addPlane, boxOf, movePlane, normalOf, planesOf } from "../scene/cuts";
import { seenDirection } from "../scene/lights";
import { setOrthographic } from "../scene/lens";
import { refused, someBounds, someScene } from "../scene/testing";
import {
  ballRadius,
  cutHandles,
  drawnPlane,
  eyeOf,
  handleDragged,
  handleStepped,
  lightHandles,
  type Handle,
} from "./handles";
import { apart, handlePx, onScreen, planeInBox } from "./project";

const screen = { width: 800, height: 600 };
const fromTheLeft = (scene: Scene): Scene =>
  withCamera(scene, { eye: vec3(480, -150, 60), target: vec3(10, 5, -5), up: vec3(0, 0, 1), verticalFovDegrees: 30 });
const named = (handles: readonly Handle[], key: string): Handle => {
  const found = handles.find((one) => one.key === key);
  if (!found) throw new Error(`no handle ${key}`);
  return found;
};
/** Dragged in small steps, as a hand does. */
function pulled(scene: Scene, key: string, x: number, y: number): Scene {
  const all = (of: Scene) => [...cutHandles(of, someBounds, screen), ...lightHandles(of, screen)];
  const start = named(all(scene), key);
  let now = scene;
  for (let i = 1; i <= 20; ++i) {
    const to = { x: start.x + (x * i) / 20, y: start.y + (y * i) / 20 };
    now = handleDragged(now, someBounds, screen, { ...named(all(now), key), behind: start.behind ?? false }, to);
  }
  expect(refused(now)).toEqual([]);
  return now;
}

describe("handles of the clip box", () => {
  it("follow the pointer from any side, also with parallel rays", () => {
    for (const scene of [someScene(), fromTheLeft(someScene()), setOrthographic(someScene(), true)]) {
      const before = named(cutHandles(scene, someBounds, screen), "z-high");
      const after = named(cutHandles(pulled(scene, "z-high", 0, 60), someBounds, screen), "z-high");
      expect(after.y - before.y).toBeCloseTo(60, 0);
      expect(after.now).toBeLessThan(before.now);
    }
  });

  it("stay within the volume, and move by one mm per key", () => {
    const scene = pulled(someScene(), "x-high", -5000, 0);
    expect(boxOf(scene, someBounds).high.x).toBeCloseTo(-119, 9);
    const one = named(cutHandles(someScene(), someBounds, screen), "x-low");
    expect(boxOf(handleStepped(someScene(), someBounds, one, 1, 0), someBounds).low.x).toBe(-119);
    expect(boxOf(handleStepped(someScene(), someBounds, one, 0, 10), someBounds).low.x).toBe(-110);
  });
});

describe("handles of a plane", () => {
  const tilted = movePlane(addPlane(someScene()), someBounds, 0, { right: 50, up: 20, offset: 15 });

  it("move it along its normal", () => {
    const scene = pulled(tilted, "plane-0", 40, 0);
    const [plane] = planesOf(scene);
    expect([plane?.right.toFixed(6), plane?.up.toFixed(6)]).toEqual(["50.000000", "20.000000"]);
    expect(plane?.offset).toBeGreaterThan(30);
  });

  it("tilt it towards the pointer about the point where it is held", () => {
    const before = drawnPlane(tilted, someBounds, 0);
    const tip = named(cutHandles(tilted, someBounds, screen), "tilt-0");
    const scene = handleDragged(tilted, someBounds, screen, tip, { x: tip.x - 30, y: tip.y - 40 });
    const [plane] = planesOf(scene);
    if (!plane || !before) throw new Error("no plane");
    expect(dot(normalOf(plane), before.base)).toBeCloseTo(plane.offset, 6);
    expect(plane.right).toBeLessThan(50);
    expect(plane.up).toBeGreaterThan(20);
  });

  it("have a position even if the plane does not intersect the box", () => {
    const away = movePlane(tilted, someBounds, 0, { right: 0, up: 0, offset: 190 });
    expect(drawnPlane(away, someBounds, 0)?.polygon).toEqual([]);
    expect(cutHandles(away, someBounds, screen).map(({ key }) => key)).toContain("plane-0");
  });
});

describe("a plane in a box", () => {
  it("is a polygon with its corners in order", () => {
    const normal = normalOf({ right: 33, up: 41 });
    const polygon = planeInBox(someBounds, normal, 12);
    expect(polygon.length).toBeGreaterThanOrEqual(3);
    for (const p of polygon) expect(dot(normal, p)).toBeCloseTo(12, 6);
    const turn = polygon.map((p, i) => {
      const q = polygon[(i + 1) % polygon.length] ?? p,
        r = polygon[(i + 2) % polygon.length] ?? p;
      const a = subtract(q, p),
        b = subtract(r, q);
      return Math.sign(dot(vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x), normal));
    });
    expect(new Set(turn).size).toBe(1);
  });
});

describe("handles of lights", () => {
  it("are where the light comes from, and follow the pointer", () => {
    for (const [key, index] of [
      ["light-0", 0],
      ["light-1", 1],
      ["light-3", 3],
    ] as const) {
      for (const scene of [someScene(), fromTheLeft(someScene())]) {
        const before = named(lightHandles(scene, screen), key);
        const to = { x: 400 - 0.7 * ballRadius(screen), y: 300 - 0.2 * ballRadius(screen) };
        const afterScene = pulled(scene, key, to.x - before.x, to.y - before.y);
        const after = named(lightHandles(afterScene, screen), key);
        expect(Math.hypot(after.x - to.x, after.y - to.y)).toBeLessThan(1);
        const eye = eyeOf(afterScene),
          light = afterScene.lights[index],
          was = scene.lights[index];
        if (!eye || !light || !was) throw new Error("no light");
        expect(seenDirection(light, eye)?.right).toBeLessThan(0);
      }
    }
  });

  it("continue on the back beyond the ball's rim, and do not exist for the environment", () => {
    const r = ballRadius(screen);
    const start = named(lightHandles(someScene(), screen), "light-0");
    const scene = pulled(someScene(), "light-0", 400 - 1.3 * r - start.x, 300 - start.y);
    const after = named(lightHandles(scene, screen), "light-0");
    expect(after.behind).toBe(true);
    expect(after.x).toBeCloseTo(400 - 0.7 * r, 0);
    expect(lightHandles(someScene(), screen)).toHaveLength(4);
  });

  it("keep the light's distance", () => {
    const far = (scene: Scene) => {
      const { shape } = scene.lights[1] ?? {};
      const centre = shape?.case === "disk" ? shape.value.centre : undefined;
      return length(vec3(centre?.x ?? 0, centre?.y ?? 0, centre?.z ?? 0));
    };
    expect(far(pulled(someScene(), "light-1", 90, -50))).toBeCloseTo(400, 6);
  });

  it("rotate by five degrees per key", () => {
    const before = named(lightHandles(someScene(), screen), "light-0");
    expect(
      named(lightHandles(handleStepped(someScene(), someBounds, before, -1, 0), screen), "light-0").now,
    ).toBeCloseTo(before.now - 5, 6);
  });
});

describe("overlapping handles", () => {
  it("are reduced to the one with the lowest rank", () => {
    const at = (x: number, rank: number) => ({ x, y: 0, rank });
    const rank = (one: { rank: number }) => one.rank;
    expect(apart([at(0, 2), at(20, 1), at(20 + handlePx, 3)], rank)).toEqual([at(20, 1), at(20 + handlePx, 3)]);
  });

  it("are projected to where they are visible", () => {
    const eye = eyeOf(someScene());
    const middle = eye && onScreen(eye, screen, vec3(0, 0, 0));
    expect([middle?.x, middle?.y].map((n) => n?.toFixed(6))).toEqual(["400.000000", "300.000000"]);
    expect(eye && onScreen(eye, screen, vec3(0, -600, 0))).toBeNull();
    const parallel = eyeOf(setOrthographic(someScene(), true));
    const wide = (y: number) => (parallel && onScreen(parallel, screen, vec3(50, y, 0))?.x) ?? 0;
    expect(wide(-100)).toBeCloseTo(wide(100), 6); // the distance does not change the size
  });
});
