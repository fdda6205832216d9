import type { PresetsApi } from "../../api/sharing";
import { scene_from_json, type Scene } from "../../protocol/messages";
import { t } from "../../texts";
import { Said } from "../state";

/** What a saved preset shows. */
export async function scene_of_preset(presets: Pick<PresetsApi, "get">, id: string): Promise<Scene> {
  const preset = await presets.get(id);
  const scene = scene_from_json(JSON.stringify(preset.scene));
  if (scene === null) throw new Said(t.presets.unreadable(preset.name));
  return scene;
}
