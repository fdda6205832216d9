import { describe, expect, it } from "vitest";
import { dot, length, vec3 } from "../input/vec3";
import { camera_of } from "../protocol/messages";
import type { Light, Scene } from "../protocol/gen/api/proto/scene_pb";
import { strength_of } from "./colour";
import { direction_of, direction_on_ball, from_world, of_patient, seen_from_front, to_world, unit_of } from "./direction";
import { add_light, colour_light, dim_light, faces_middle, intensity_of, lock_light, place_light, place_of, radiance_of, size_light, size_of } from "./lights";
import { some_scene } from "./testing";

const light = (scene: Scene, index: number): Light => {
  const found = scene.lights[index];
  if (!found) throw new Error("no such light");
  return found;
};
const directions = [{ right: 0, up: 0 }, { right: -90, up: 30 }, { right: 135, up: -60 }, { right: 180, up: 0 }, { right: 20, up: 89 }];

describe("where a light is", () => {
  it("it is where it was put, at any shape, and a square looks to the middle", () => {
    for (const index of [0, 1, 2, 3])
      for (const direction of directions) {
        const scene = place_light(some_scene(), index, { ...direction, distance: 700 });
        const place = place_of(light(scene, index));
        expect(place?.up).toBeCloseTo(direction.up, 6);
        expect(Math.abs(Math.sin(((place?.right ?? 0) - direction.right) * (Math.PI / 180)))).toBeLessThan(1e-6);
        expect(place?.distance).toBeCloseTo(700, 6);
        if (index === 0) expect(faces_middle(light(scene, index))).toBe(true);
      }
  });

  it("to the right is to the right of the picture for one that is locked, and the patient's left for one that is not", () => {
    const locked = light(place_light(some_scene(), 0, { right: 90, up: 0, distance: 100 }), 0);
    expect(locked.shape.case === "rectangle" && (locked.shape.value.corner?.x ?? 0)).toBeGreaterThan(90);
    const free = light(place_light(some_scene(), 1, { right: 90, up: 0, distance: 100 }), 1);
    expect(free.shape.case === "disk" && free.shape.value.centre?.x).toBeCloseTo(100, 9);
    expect(free.shape.case === "disk" && free.shape.value.normal?.x).toBeCloseTo(-1, 9);
  });

  it("from straight above it can be turned further", () => {
    const scene = place_light(some_scene(), 0, { up: 90, right: 30 });
    expect(place_of(light(scene, 0))?.up).toBeCloseTo(90, 3);
    expect(faces_middle(light(scene, 0))).toBe(true);
  });

  it("locked to the camera and let go again it is where it was", () => {
    const pose = camera_of(some_scene());
    if (!pose) throw new Error("no camera");
    for (const index of [1, 2, 3]) {
      const before = light(some_scene(), index);
      const there = lock_light(some_scene(), index, true, pose);
      const back = light(lock_light(there, index, false, pose), index);
      expect(light(there, index).cameraLocked).toBe(true);
      expect(place_of(back)?.distance).toBeCloseTo(place_of(before)?.distance ?? 0, 6);
      expect(place_of(back)?.right).toBeCloseTo(place_of(before)?.right ?? 0, 6);
    }
  });
});

describe("what a light gives", () => {
  it("is the same at any size", () => {
    for (const index of [0, 1, 3]) {
      const scene = some_scene();
      const power = (one: Light) => strength_of(radiance_of(one)) * (size_of(one) ?? 0) ** 2;
      const larger = light(size_light(scene, index, 3 * (size_of(light(scene, index)) ?? 0)), index);
      expect(power(larger)).toBeCloseTo(power(light(scene, index)), 6);
      expect(place_of(larger)?.distance).toBeCloseTo(place_of(light(scene, index))?.distance ?? 0, 6);
    }
  });

  it("of a point that becomes a ball is what the point gave", () => {
    const ball = light(size_light(some_scene(), 2, 20), 2);
    expect(strength_of(radiance_of(ball)) * Math.PI * 100).toBeCloseTo(5000, 6);
  });

  it("is told as 1 where the scene says nothing, and is never 0, which would mean 1", () => {
    expect(intensity_of(light(some_scene(), 0))).toBe(1);
    expect(light(dim_light(some_scene(), 0, 0), 0).intensity).toBeGreaterThan(0);
  });

  it("of an added light lies above to the left of the picture, as bright for any shape", () => {
    for (const shape of ["rectangle", "disk", "sphere"] as const) {
      const scene = add_light(some_scene(), shape, "new", 150);
      const added = light(scene, scene.lights.length - 1);
      const place = place_of(added);
      expect(place && place.right < 0 && place.up > 0).toBe(true);
      const area = shape === "rectangle" ? (size_of(added) ?? 0) ** 2 : (Math.PI * (size_of(added) ?? 0) ** 2) / 4;
      expect((strength_of(radiance_of(added)) * area) / (place?.distance ?? 1) ** 2).toBeCloseTo(8, 6);
    }
  });

  it("keeps its strength in another colour", () => {
    const blue = light(colour_light(some_scene(), 0, { $typeName: "diaphane.v1.Rgb", r: 0.1, g: 0.1, b: 0.5 }), 0);
    expect(strength_of(radiance_of(blue))).toBeCloseTo(40, 9);
  });
});

describe("directions", () => {
  it("of the patient and of who looks from the front are each other's way back", () => {
    const v = vec3(1, 2, 3);
    expect(of_patient(seen_from_front(v))).toEqual(v);
    expect(seen_from_front(vec3(1, 0, 0))).toEqual(vec3(1, 0, -0)); // the patient's left is on the right of the picture
    expect(direction_of(seen_from_front(vec3(0, -1, 0)))).toEqual({ right: 0, up: 0 });
  });

  it("into the camera's frame and out again nothing moves", () => {
    const pose = camera_of(some_scene());
    if (!pose) throw new Error("no camera");
    const v = vec3(10, -20, 30);
    const back = to_world(pose, from_world(pose, v));
    expect(length(vec3(back.x - v.x, back.y - v.y, back.z - v.z))).toBeLessThan(1e-9);
  });

  it("on the ball: its middle is in front, beyond the rim is behind, at any place a direction", () => {
    expect(direction_on_ball(0, 0, false).direction.up).toBeCloseTo(0, 9);
    expect(direction_on_ball(0.5, 0, false).direction.right).toBeCloseTo(30, 6);
    expect(direction_on_ball(1.5, 0, false).direction.right).toBeCloseTo(150, 6);
    expect(direction_on_ball(0, -0.5, false).direction.up).toBeCloseTo(30, 6);
    for (let x = -3; x <= 3; x += 0.25)
      for (let y = -3; y <= 3; y += 0.25) {
        const { direction } = direction_on_ball(x, y, false);
        expect(dot(unit_of(direction), unit_of(direction))).toBeCloseTo(1, 9);
      }
  });
});
