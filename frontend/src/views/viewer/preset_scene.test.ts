import { expect, test } from "vitest";
import { scene_to_json } from "../../protocol/messages";
import { some_scene } from "../../scene/testing";
import { t } from "../../texts";
import { Said } from "../state";
import { scene_of_preset } from "./preset_scene";

const presets = (scene: object) => ({ get: (id: string) => Promise.resolve({ id, name: "Best", scene }) as never });

test("a saved preset is the scene that it was", async () => {
  const scene = some_scene();
  expect(scene_to_json(await scene_of_preset(presets(JSON.parse(scene_to_json(scene)) as object), "a"))).toBe(scene_to_json(scene));
});

test("one that cannot be read is said by its name", async () => {
  const read = scene_of_preset(presets({ camera: "none" }), "a");
  await expect(read).rejects.toThrow(Said);
  await expect(read).rejects.toThrow(t.presets.unreadable("Best"));
});
