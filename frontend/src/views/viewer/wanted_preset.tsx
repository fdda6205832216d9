import { useEffect } from "preact/hooks";
import type { ViewerSession } from "../../video/viewer_session";
import { useApp } from "../state";
import { showPreset } from "./preset_scene";

const look = /^#look=([0-9a-f-]{36})$/;

/** Shows the scan with the preset that a gallery link names in its fragment. */
export function WantedPreset({ session }: { readonly session: ViewerSession }) {
  const app = useApp();
  const ready = session.editor.scene.value !== null;
  useEffect(() => {
    const presetId = ready ? look.exec(location.hash)?.[1] : undefined;
    if (presetId === undefined) return;
    history.replaceState(history.state, "", location.pathname); // a reload keeps the later edits
    showPreset(app.api.presets, presetId, session).catch(() => undefined); // the picture is shown without the preset
  }, [app, session, ready]);
  return null;
}
