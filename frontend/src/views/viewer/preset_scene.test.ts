import { expect, test } from "vitest";
import { sceneToJson } from "../../protocol/messages";
import { someScene } from "../../scene/testing";
import { t } from "../../texts";
import { UserError } from "../state";
import { setTexture, textureOf } from "../../scene/textures";
import { savedText, sceneOfPreset, toPreset } from "./preset_scene";

const presets = (scene: object) => ({ get: (id: string) => Promise.resolve({ id, name: "Best", scene }) as never });

test("a saved preset restores its scene", async () => {
  const scene = someScene();
  expect(sceneToJson(await sceneOfPreset(presets(JSON.parse(sceneToJson(scene)) as object), "a"))).toBe(
    sceneToJson(scene),
  );
});

test("an unreadable preset is reported by its name", async () => {
  const read = sceneOfPreset(presets({ camera: "none" }), "a");
  await expect(read).rejects.toThrow(UserError);
  await expect(read).rejects.toThrow(t.presets.unreadable("Best"));
});

test("a light pattern is not saved, and the user is told", async () => {
  const scene = setTexture(someScene(), 0, new Uint8Array([1, 2, 3]));
  expect(scene.lights[0] && textureOf(scene.lights[0])).not.toBeNull();
  const saved = await sceneOfPreset(presets(toPreset(scene)), "a");
  expect(saved.lights.map(textureOf)).toEqual(saved.lights.map(() => null));
  expect(saved.lights.length).toBe(scene.lights.length);
  expect(savedText("Best", scene)).toContain(t.presets.withoutPatterns);
  expect(savedText("Best", someScene())).toBe(t.presets.saved("Best"));
});
