import { useEffect, useRef, useState } from "preact/hooks";
import type { Scene } from "../../../protocol/messages";
import { scene_of_link } from "../../../scene/scene_link";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Icon } from "../../icons";
import { Notice } from "../../shell";

/** The address may say how the scan is to be shown. What is no scene, or none that the renderer takes, changes nothing. */
export function LinkedView({ session }: { readonly session: ViewerSession }) {
  const [fault, set_fault] = useState("");
  const [pasted, set_pasted] = useState(0);
  const before = useRef<Scene | null>(null);
  const ready = session.scene.value !== null && session.connection.value.phase === "live";
  const refused = session.problem.value !== "";
  useEffect(() => {
    // Another link to the same scan, put into the address of this page: the browser loads nothing.
    const changed = () => set_pasted((times) => times + 1);
    addEventListener("hashchange", changed);
    return () => removeEventListener("hashchange", changed);
  }, []);
  useEffect(() => {
    if (!ready || !location.hash.startsWith("#view=")) return;
    const hash = location.hash;
    history.replaceState(null, "", location.pathname); // a reload shows what the picture has become since
    set_fault("");
    void scene_of_link(hash).then((linked) => {
      if (linked.kind === "scene") {
        before.current = session.scene.value;
        session.show_scene(linked.scene);
      } else if (linked.kind !== "none") set_fault(linked.kind === "newer" ? t.take.link_newer : t.take.link_damaged);
    });
  }, [session, ready, pasted]);
  useEffect(() => {
    const first = before.current;
    if (!refused || !first) return;
    before.current = null;
    session.show_scene(first);
    set_fault(t.take.link_damaged);
  }, [session, refused]);
  if (!fault) return null;
  return (
    <div class="glass linked-fault">
      <Notice kind="bad">{fault}</Notice>
      <button type="button" class="icon-button" aria-label={t.take.hide} title={t.take.hide} onClick={() => set_fault("")}><Icon name="close" /></button>
    </div>
  );
}
