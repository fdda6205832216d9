import type { Role } from "../../live/role";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { shownName } from "./share_dialog";

/** For a follower: shows who is presenting, and the switch to a free camera. */
export function LiveLine({ session, role }: { readonly session: ViewerSession; readonly role: Role }) {
  const presenter = role.presenter;
  return (
    <div class="glass live-line">
      <p role="status">{presenter ? t.live.presents(shownName(presenter)) : t.live.presenterAway}</p>
      <button
        type="button"
        class="button"
        aria-pressed={role.freeCamera}
        onClick={() => session.useFreeCamera(!role.freeCamera)}
      >
        {t.live.freeCamera}
      </button>
    </div>
  );
}
