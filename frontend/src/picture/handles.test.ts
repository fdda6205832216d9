import { describe, expect, it } from "vitest";
import { dot, length, subtract, vec3 } from "../input/vec3";
import { with_camera } from "../protocol/messages";
import type { Scene } from "../protocol/gen/api/proto/scene_pb";
import { add_plane, box_of, move_plane, normal_of, planes_of } from "../scene/cuts";
import { seen_direction } from "../scene/lights";
import { set_orthographic } from "../scene/lens";
import { refused, some_bounds, some_scene } from "../scene/testing";
import { ball_radius, cut_handles, drawn_plane, eye_of, handle_dragged, handle_stepped, light_handles, type Handle } from "./handles";
import { apart, handle_px, on_screen, plane_in_box } from "./project";

const screen = { width: 800, height: 600 };
const from_the_left = (scene: Scene): Scene => with_camera(scene, { eye: vec3(480, -150, 60), target: vec3(10, 5, -5), up: vec3(0, 0, 1), verticalFovDegrees: 30 });
const named = (handles: readonly Handle[], key: string): Handle => {
  const found = handles.find((one) => one.key === key);
  if (!found) throw new Error(`no handle ${key}`);
  return found;
};
/** Dragged in small steps, as a hand does. */
function pulled(scene: Scene, key: string, x: number, y: number): Scene {
  const all = (of: Scene) => [...cut_handles(of, some_bounds, screen), ...light_handles(of, screen)];
  const start = named(all(scene), key);
  let now = scene;
  for (let i = 1; i <= 20; ++i) {
    const to = { x: start.x + (x * i) / 20, y: start.y + (y * i) / 20 };
    now = handle_dragged(now, some_bounds, screen, { ...named(all(now), key), behind: start.behind ?? false }, to);
  }
  expect(refused(now)).toEqual([]);
  return now;
}

describe("handles of the clip box", () => {
  it("stay under the hand, from any side and with parallel rays", () => {
    for (const scene of [some_scene(), from_the_left(some_scene()), set_orthographic(some_scene(), true)]) {
      const before = named(cut_handles(scene, some_bounds, screen), "z-high");
      const after = named(cut_handles(pulled(scene, "z-high", 0, 60), some_bounds, screen), "z-high");
      expect(after.y - before.y).toBeCloseTo(60, 0);
      expect(after.now).toBeLessThan(before.now);
    }
  });

  it("cut no more than there is, and by keys a mm", () => {
    const scene = pulled(some_scene(), "x-high", -5000, 0);
    expect(box_of(scene, some_bounds).high.x).toBeCloseTo(-119, 9);
    const one = named(cut_handles(some_scene(), some_bounds, screen), "x-low");
    expect(box_of(handle_stepped(some_scene(), some_bounds, one, 1, 0), some_bounds).low.x).toBe(-119);
    expect(box_of(handle_stepped(some_scene(), some_bounds, one, 0, 10), some_bounds).low.x).toBe(-110);
  });
});

describe("handles of a plane", () => {
  const tilted = move_plane(add_plane(some_scene()), some_bounds, 0, { right: 50, up: 20, offset: 15 });

  it("move it along its normal", () => {
    const scene = pulled(tilted, "plane-0", 40, 0);
    const [plane] = planes_of(scene);
    expect([plane?.right.toFixed(6), plane?.up.toFixed(6)]).toEqual(["50.000000", "20.000000"]);
    expect(plane?.offset).toBeGreaterThan(30);
  });

  it("tilt it about where it is taken hold of, towards the hand", () => {
    const before = drawn_plane(tilted, some_bounds, 0);
    const tip = named(cut_handles(tilted, some_bounds, screen), "tilt-0");
    const scene = handle_dragged(tilted, some_bounds, screen, tip, { x: tip.x - 30, y: tip.y - 40 });
    const [plane] = planes_of(scene);
    if (!plane || !before) throw new Error("no plane");
    expect(dot(normal_of(plane), before.base)).toBeCloseTo(plane.offset, 6);
    expect(plane.right).toBeLessThan(50);
    expect(plane.up).toBeGreaterThan(20);
  });

  it("have a place where the plane passes beside the box, too", () => {
    const away = move_plane(tilted, some_bounds, 0, { right: 0, up: 0, offset: 190 });
    expect(drawn_plane(away, some_bounds, 0)?.polygon).toEqual([]);
    expect(cut_handles(away, some_bounds, screen).map(({ key }) => key)).toContain("plane-0");
  });
});

describe("a plane in a box", () => {
  it("is a polygon in the plane, in order around", () => {
    const normal = normal_of({ right: 33, up: 41 });
    const polygon = plane_in_box(some_bounds, normal, 12);
    expect(polygon.length).toBeGreaterThanOrEqual(3);
    for (const p of polygon) expect(dot(normal, p)).toBeCloseTo(12, 6);
    const turn = polygon.map((p, i) => {
      const q = polygon[(i + 1) % polygon.length] ?? p, r = polygon[(i + 2) % polygon.length] ?? p;
      const a = subtract(q, p), b = subtract(r, q);
      return Math.sign(dot(vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x), normal));
    });
    expect(new Set(turn).size).toBe(1);
  });
});

describe("handles of lights", () => {
  it("stand where the light comes from, and follow the hand", () => {
    for (const [key, index] of [["light-0", 0], ["light-1", 1], ["light-3", 3]] as const) {
      for (const scene of [some_scene(), from_the_left(some_scene())]) {
        const before = named(light_handles(scene, screen), key);
        const to = { x: 400 - 0.7 * ball_radius(screen), y: 300 - 0.2 * ball_radius(screen) };
        const after_scene = pulled(scene, key, to.x - before.x, to.y - before.y);
        const after = named(light_handles(after_scene, screen), key);
        expect(Math.hypot(after.x - to.x, after.y - to.y)).toBeLessThan(1);
        const eye = eye_of(after_scene), light = after_scene.lights[index], was = scene.lights[index];
        if (!eye || !light || !was) throw new Error("no light");
        expect(seen_direction(light, eye)?.right).toBeLessThan(0);
      }
    }
  });

  it("go on at the back beyond the ball's rim, and the environment has none", () => {
    const r = ball_radius(screen);
    const start = named(light_handles(some_scene(), screen), "light-0");
    const scene = pulled(some_scene(), "light-0", 400 - 1.3 * r - start.x, 300 - start.y);
    const after = named(light_handles(scene, screen), "light-0");
    expect(after.behind).toBe(true);
    expect(after.x).toBeCloseTo(400 - 0.7 * r, 0);
    expect(light_handles(some_scene(), screen)).toHaveLength(4);
  });

  it("keep their distance", () => {
    const far = (scene: Scene) => {
      const { shape } = scene.lights[1] ?? {};
      const centre = shape?.case === "disk" ? shape.value.centre : undefined;
      return length(vec3(centre?.x ?? 0, centre?.y ?? 0, centre?.z ?? 0));
    };
    expect(far(pulled(some_scene(), "light-1", 90, -50))).toBeCloseTo(400, 6);
  });

  it("turn by keys five degrees", () => {
    const before = named(light_handles(some_scene(), screen), "light-0");
    expect(named(light_handles(handle_stepped(some_scene(), some_bounds, before, -1, 0), screen), "light-0").now).toBeCloseTo(before.now - 5, 6);
  });
});

describe("handles that would lie on each other", () => {
  it("are one: that with the lowest rank", () => {
    const at = (x: number, rank: number) => ({ x, y: 0, rank });
    const rank = (one: { rank: number }) => one.rank;
    expect(apart([at(0, 2), at(20, 1), at(20 + handle_px, 3)], rank)).toEqual([at(20, 1), at(20 + handle_px, 3)]);
  });

  it("are where they are seen", () => {
    const eye = eye_of(some_scene());
    const middle = eye && on_screen(eye, screen, vec3(0, 0, 0));
    expect([middle?.x, middle?.y].map((n) => n?.toFixed(6))).toEqual(["400.000000", "300.000000"]);
    expect(eye && on_screen(eye, screen, vec3(0, -600, 0))).toBeNull();
    const parallel = eye_of(set_orthographic(some_scene(), true));
    const wide = (y: number) => (parallel && on_screen(parallel, screen, vec3(50, y, 0))?.x) ?? 0;
    expect(wide(-100)).toBeCloseTo(wide(100), 6); // nearer is no larger
  });
});
