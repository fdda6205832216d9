import { useEffect, useRef, useState } from "preact/hooks";
import type { Scene } from "../../../protocol/messages";
import { scene_of_link } from "../../../scene/scene_link";
import { t } from "../../../texts/en";
import type { ViewerSession } from "../../../video/viewer_session";
import { Notice } from "../../shell";

/** The address may say how the scan is to be shown. What is no scene, or none that the renderer takes, changes nothing. */
export function LinkedView({ session }: { readonly session: ViewerSession }) {
  const [fault, set_fault] = useState("");
  const before = useRef<Scene | null>(null);
  const ready = session.scene.value !== null && session.connection.value.phase === "live";
  const refused = session.problem.value !== "";
  useEffect(() => {
    if (!ready || !location.hash.startsWith("#view=")) return;
    const hash = location.hash;
    history.replaceState(null, "", location.pathname); // a reload shows what the picture has become since
    void scene_of_link(hash).then((linked) => {
      if (linked.kind === "scene") {
        before.current = session.scene.value;
        session.show_scene(linked.scene);
      } else if (linked.kind !== "none") set_fault(linked.kind === "newer" ? t.take.link_newer : t.take.link_damaged);
    });
  }, [session, ready]);
  useEffect(() => {
    const first = before.current;
    if (!refused || !first) return;
    before.current = null;
    session.show_scene(first);
    set_fault(t.take.link_damaged);
  }, [session, refused]);
  return fault ? <div class="glass linked-fault"><Notice kind="bad">{fault}</Notice></div> : null;
}
