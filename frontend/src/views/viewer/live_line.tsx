import type { Role } from "../../live/role";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { shown_name } from "./share_dialog";

/** For a follower: who turns the picture, and the way to a camera of one's own. */
export function LiveLine({ session, role }: { readonly session: ViewerSession; readonly role: Role }) {
  const presenter = role.presenter;
  return (
    <div class="glass live-line">
      <p role="status">{presenter ? t.live.presents(shown_name(presenter)) : t.live.presenter_away}</p>
      <button type="button" class="button" aria-pressed={role.own_camera} onClick={() => session.use_own_camera(!role.own_camera)}>
        {t.live.own_camera}
      </button>
    </div>
  );
}
