import { expect, test } from "vitest";
import { sceneToJson } from "../../protocol/messages";
import { someScene } from "../../scene/testing";
import { t } from "../../texts";
import { Said } from "../state";
import { sceneOfPreset } from "./preset_scene";

const presets = (scene: object) => ({ get: (id: string) => Promise.resolve({ id, name: "Best", scene }) as never });

test("a saved preset is the scene that it was", async () => {
  const scene = someScene();
  expect(sceneToJson(await sceneOfPreset(presets(JSON.parse(sceneToJson(scene)) as object), "a"))).toBe(
    sceneToJson(scene),
  );
});

test("one that cannot be read is said by its name", async () => {
  const read = sceneOfPreset(presets({ camera: "none" }), "a");
  await expect(read).rejects.toThrow(Said);
  await expect(read).rejects.toThrow(t.presets.unreadable("Best"));
});
