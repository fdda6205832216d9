import type { PresetsApi } from "../../api/sharing";
import { sceneFromJson, type Scene } from "../../protocol/messages";
import { t } from "../../texts";
import { Said } from "../state";

/** Returns the scene of a saved preset. */
export async function sceneOfPreset(presets: Pick<PresetsApi, "get">, id: string): Promise<Scene> {
  const preset = await presets.get(id);
  const scene = sceneFromJson(JSON.stringify(preset.scene));
  if (scene === null) throw new Said(t.presets.unreadable(preset.name));
  return scene;
}
