import type { PresetsApi } from "../../api/sharing";
import { sceneFromJson, sceneToJson, type Scene } from "../../protocol/messages";
import { hasTextures, withoutTextures } from "../../scene/textures";
import { t } from "../../texts";
import { Said } from "../state";

/** Returns the scene of a saved preset. */
export async function sceneOfPreset(presets: Pick<PresetsApi, "get">, id: string): Promise<Scene> {
  const preset = await presets.get(id);
  const scene = sceneFromJson(JSON.stringify(preset.scene));
  if (scene === null) throw new Said(t.presets.unreadable(preset.name));
  return scene;
}

/** Returns the scene as a preset stores it. The server keeps no light patterns in presets. */
export const toPreset = (scene: Scene): object => JSON.parse(sceneToJson(withoutTextures(scene))) as object;

/** Returns what to say once a scene has been saved, including what the preset does not keep. */
export const savedText = (name: string, scene: Scene): string =>
  hasTextures(scene) ? `${t.presets.saved(name)} ${t.presets.withoutPatterns}` : t.presets.saved(name);
