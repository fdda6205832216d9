import { useEffect } from "preact/hooks";
import { ApiProblem } from "../../api/client";
import { storedIn } from "../../scene/environments";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { useApp } from "../state";

/** Says that the environment of the shown scene no longer exists. The renderer shows a uniform light instead. */
export function LostEnvironment({ session }: { readonly session: ViewerSession }) {
  const app = useApp();
  const scene = session.editor.scene.value;
  const ids = scene ? storedIn(scene).join() : "";
  useEffect(() => {
    if (!ids) return;
    let here = true;
    const check = async () => {
      for (const id of ids.split(",")) await app.api.environments.get(id);
    };
    check().catch((thrown: unknown) => {
      const lost = thrown instanceof ApiProblem && thrown.status === 404;
      if (here && lost) session.problem.value = t.viewer.lostEnvironment;
    });
    return () => {
      here = false;
    };
  }, [app, session, ids]);
  return null;
}
