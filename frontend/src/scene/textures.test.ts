import { describe, expect, it } from "vitest";
import { fitted, is_sky, lamp_textures, most_texture_bytes, set_texture, sky_textures, texture_fits, texture_names, texture_of, texture_pixels } from "./textures";
import { reset_part } from "./parts";
import { refused, some_scene } from "./testing";

const bytes = (n: number) => new Uint8Array(n).fill(7);

describe("textures of lights", () => {
  it("are put on any light and taken off again", () => {
    some_scene().lights.forEach((_, i) => {
      const scene = set_texture(some_scene(), i, bytes(100));
      const light = scene.lights[i];
      expect(light && texture_of(light)).toEqual(bytes(100));
      expect(refused(scene)).toEqual([]);
      expect(set_texture(scene, i, null)).toEqual(some_scene());
      expect(reset_part(scene, some_scene(), "light")).toEqual(some_scene());
    });
    expect(set_texture(some_scene(), 99, bytes(1))).toEqual(some_scene());
  });

  it("all of a scene's go into one message", () => {
    const full = set_texture(some_scene(), 0, bytes(most_texture_bytes - 10));
    expect(texture_fits(full, 1, 10)).toBe(true);
    expect(texture_fits(full, 1, 11)).toBe(false);
    expect(set_texture(full, 1, bytes(11))).toBe(full);
    expect(texture_fits(full, 0, most_texture_bytes)).toBe(true); // in the place of its own
  });

  it("those made here have light and shade, and a sky's are twice as wide as high", () => {
    for (const name of [...lamp_textures, ...sky_textures]) {
      const { width, height, rgba } = texture_pixels(name);
      expect(width).toBe((sky_textures as readonly string[]).includes(name) ? 2 * height : height);
      expect(rgba).toHaveLength(4 * width * height);
      const red = rgba.filter((_, i) => i % 4 === 0);
      expect(Math.max(...red) - Math.min(...red)).toBeGreaterThan(150);
      expect(rgba.filter((_, i) => i % 4 === 3).every((a) => a === 255)).toBe(true);
    }
  });

  it("the sky is bright above, and a sky has those of a sky", () => {
    const { width, height, rgba } = texture_pixels("horizon");
    expect(rgba[0]).toBeGreaterThan(200);
    expect(rgba[4 * width * (height - 1)]).toBeLessThan(60);
    for (const light of some_scene().lights) expect(texture_names(light)).toBe(is_sky(light) ? sky_textures : lamp_textures);
  });

  it("one's own keeps its shape", () => {
    expect(fitted(4000, 1000, 128)).toEqual({ width: 128, height: 32 });
    expect(fitted(20, 10, 128)).toEqual({ width: 20, height: 10 });
    expect(fitted(10_000, 3, 128)).toEqual({ width: 128, height: 1 });
  });
});
