import { describe, expect, it } from "vitest";
import {
  fitted,
  isSky,
  lampTextures,
  mostTextureBytes,
  projectionFor,
  setTexture,
  skyTextures,
  textureFits,
  textureNames,
  textureOf,
  texturePixels,
  type TextureName,
} from "./textures";
import { length } from "../input/vec3";
import { cameraOf } from "../protocol/messages";
import { heightAtTarget } from "./lens";
import { middleOf } from "./light_geometry";
import { resetPart } from "./parts";
import { refused, someScene } from "./testing";

const bytes = (n: number) => new Uint8Array(n).fill(7);

describe("textures of lights", () => {
  it("can be set and removed on any light", () => {
    someScene().lights.forEach((_, i) => {
      const scene = setTexture(someScene(), i, bytes(100));
      const light = scene.lights[i];
      expect(light && textureOf(light)).toEqual(bytes(100));
      expect(refused(scene)).toEqual([]);
      expect(setTexture(scene, i, null)).toEqual(someScene());
      expect(resetPart(scene, someScene(), "light")).toEqual(someScene());
    });
    expect(setTexture(someScene(), 99, bytes(1))).toEqual(someScene());
  });

  it("of a scene fit into one message together", () => {
    const full = setTexture(someScene(), 0, bytes(mostTextureBytes - 10));
    expect(textureFits(full, 1, 10)).toBe(true);
    expect(textureFits(full, 1, 11)).toBe(false);
    expect(setTexture(full, 1, bytes(11))).toBe(full);
    expect(textureFits(full, 0, mostTextureBytes)).toBe(true); // in the place of its own
  });

  it("have light and dark parts, and those of a sky are twice as wide as high", () => {
    for (const name of [...lampTextures, ...skyTextures]) {
      const { width, height, rgba } = texturePixels(name);
      expect(width).toBe((skyTextures as readonly string[]).includes(name) ? 2 * height : height);
      expect(rgba).toHaveLength(4 * width * height);
      const red = rgba.filter((_, i) => i % 4 === 0);
      expect(Math.max(...red) - Math.min(...red)).toBeGreaterThan(150);
      expect(rgba.filter((_, i) => i % 4 === 3).every((a) => a === 255)).toBe(true);
    }
  });

  it("are bright above for a sky, which offers only sky patterns", () => {
    const { width, height, rgba } = texturePixels("horizon");
    expect(rgba[0]).toBeGreaterThan(200);
    expect(rgba[4 * width * (height - 1)]).toBeLessThan(60);
    for (const light of someScene().lights)
      if (isSky(light)) expect(textureNames(light)).toBe(skyTextures);
      else expect(textureNames(light)).toContain("ring");
  });

  it("are offered only where they are visible: a square or disk can project them", () => {
    for (const light of someScene().lights)
      if (!isSky(light))
        expect(textureNames(light).includes("window")).toBe(["rectangle", "disk"].includes(light.shape.case ?? ""));
  });

  it("are projected over the picture, unless the surface of the lamp shows them", () => {
    const scene = someScene();
    const angle = (index: number, name?: TextureName) =>
      projectionFor(scene, scene.lights[index] ?? expect.unreachable(), name);
    for (const name of ["window", "blinds", undefined] as const) {
      const half = (angle(0, name) * Math.PI) / 360;
      const lamp = middleOf(scene.lights[0] ?? expect.unreachable());
      const height = heightAtTarget(cameraOf(scene) ?? expect.unreachable());
      expect(2 * Math.tan(half) * length(lamp ?? expect.unreachable())).toBeCloseTo(0.8 * height, 6);
    }
    expect(angle(0, "soft")).toBe(0);
    expect(angle(2, "window")).toBe(0); // a sphere
    expect(setTexture(scene, 0, bytes(9), 33).lights[0]?.shape.value?.texture?.projectionDegrees).toBe(33);
    expect(refused(setTexture(scene, 0, bytes(9), 33))).toEqual([]);
  });

  it("keep the shape of the user's own image", () => {
    expect(fitted(4000, 1000, 128)).toEqual({ width: 128, height: 32 });
    expect(fitted(20, 10, 128)).toEqual({ width: 20, height: 10 });
    expect(fitted(10_000, 3, 128)).toEqual({ width: 128, height: 1 });
  });
});
