import type { PresetsApi } from "../../api/sharing";
import { sceneFromJson, sceneToJson, type Scene } from "../../protocol/messages";
import { hasTextures, withoutTextures } from "../../scene/textures";
import { t } from "../../texts";
import { UserError } from "../state";

/** Returns the scene of a saved preset. */
export async function sceneOfPreset(presets: Pick<PresetsApi, "get">, id: string): Promise<Scene> {
  const preset = await presets.get(id);
  const scene = sceneFromJson(JSON.stringify(preset.scene));
  if (scene === null) throw new UserError(t.presets.unreadable(preset.name));
  return scene;
}

/** Returns the scene as a preset stores it. The server keeps no light patterns in presets. */
export const toPreset = (scene: Scene): object => JSON.parse(sceneToJson(withoutTextures(scene))) as object;

/** Returns the message for a saved scene, which mentions the parts that the preset does not keep. */
export const savedText = (name: string, scene: Scene): string =>
  hasTextures(scene) ? `${t.presets.saved(name)} ${t.presets.withoutPatterns}` : t.presets.saved(name);
