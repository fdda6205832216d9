import { describe, expect, it } from "vitest";
import {
  fitted,
  isSky,
  lampTextures,
  mostTextureBytes,
  setTexture,
  skyTextures,
  textureFits,
  textureNames,
  textureOf,
  texturePixels,
} from "./textures";
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
    for (const light of someScene().lights) expect(textureNames(light)).toBe(isSky(light) ? skyTextures : lampTextures);
  });

  it("keep the shape of the user's own image", () => {
    expect(fitted(4000, 1000, 128)).toEqual({ width: 128, height: 32 });
    expect(fitted(20, 10, 128)).toEqual({ width: 20, height: 10 });
    expect(fitted(10_000, 3, 128)).toEqual({ width: 128, height: 1 });
  });
});
