import type { PresetsApi } from "../../api/sharing";
import type { SavedPreset } from "../../api/types";
import { showSet, viewSet } from "../../marks/library";
import { annotationsFromJson } from "../../protocol/mark_messages";
import type { ViewerSession } from "../../video/viewer_session";
import { sceneFromJson, sceneToJson, type Scene } from "../../protocol/messages";
import { hasTextures, withoutTextures } from "../../scene/textures";
import { t } from "../../texts";
import { UserError } from "../state";

/** Returns the scene of a saved preset. */
export async function sceneOfPreset(presets: Pick<PresetsApi, "get">, id: string): Promise<Scene> {
  return sceneOf(await presets.get(id));
}

function sceneOf(preset: SavedPreset): Scene {
  const scene = sceneFromJson(JSON.stringify(preset.scene));
  if (scene === null) throw new UserError(t.presets.unreadable(preset.name));
  return scene;
}

/** Shows a saved preset with its marks and measurements, which replace those of another preset. */
export async function showPreset(
  presets: Pick<PresetsApi, "get">,
  id: string,
  session: Pick<ViewerSession, "editor" | "marks" | "slices">,
): Promise<void> {
  const preset = await presets.get(id);
  session.editor.showScene(sceneOf(preset));
  showSet(session, viewSet, annotationsFromJson(preset.annotations ?? {}) ?? { marks: [], measures: [] });
}

/** Returns the scene as a preset stores it. The server keeps no light patterns in presets. */
export const toPreset = (scene: Scene): object => JSON.parse(sceneToJson(withoutTextures(scene))) as object;

/** Returns the message for a saved scene, which mentions the parts that the preset does not keep. */
export const savedText = (name: string, scene: Scene): string =>
  hasTextures(scene) ? `${t.presets.saved(name)} ${t.presets.withoutPatterns}` : t.presets.saved(name);
