import { useEffect, useRef, useState } from "preact/hooks";
import type { Scene } from "../../../protocol/messages";
import { showSet, viewSet } from "../../../marks/library";
import { sceneOfLink } from "../../../scene/scene_link";
import { lampTextures, skyTextures } from "../../../scene/textures";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Icon } from "../../icons";
import { Notice } from "../../shell";
import { textureFiles } from "../settings/texture_files";

/** Shows the scene in the fragment of the URL, if there is one. An invalid scene changes nothing. */
export function LinkedView({ session }: { readonly session: ViewerSession }) {
  const [fault, setFault] = useState("");
  const [pasted, setPasted] = useState(0);
  const before = useRef<Scene | null>(null);
  const ready = session.editor.scene.value !== null && session.connection.value.phase === "live";
  const refused = session.problem.value !== "";
  useEffect(() => {
    // Handles another link to the same scan in this tab, for which the browser does not load the page again.
    const changed = () => setPasted((times) => times + 1);
    addEventListener("hashchange", changed);
    return () => removeEventListener("hashchange", changed);
  }, []);
  useEffect(() => {
    if (!ready || !location.hash.startsWith("#view=")) return;
    const hash = location.hash;
    history.replaceState(history.state, "", location.pathname); // a reload keeps the later edits
    setFault("");
    const read = async () => sceneOfLink(hash, await textureFiles([...lampTextures, ...skyTextures]));
    void read().then((linked) => {
      if (linked.kind === "scene") {
        before.current = session.editor.toSave();
        session.editor.showScene(linked.scene);
        if (linked.annotations) showSet(session, viewSet, linked.annotations);
      } else if (linked.kind !== "none") setFault(linked.kind === "newer" ? t.take.linkNewer : t.take.linkDamaged);
    });
  }, [session, ready, pasted]);
  useEffect(() => {
    const first = before.current;
    if (!refused || !first) return;
    before.current = null;
    session.editor.showScene(first);
    setFault(t.take.linkDamaged);
  }, [session, refused]);
  if (!fault) return null;
  return (
    <div class="glass linked-fault">
      <Notice kind="bad">{fault}</Notice>
      <button
        type="button"
        class="icon-button"
        aria-label={t.take.hide}
        title={t.take.hide}
        onClick={() => setFault("")}
      >
        <Icon name="close" />
      </button>
    </div>
  );
}
