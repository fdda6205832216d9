import type { Role } from "../../live/role";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { shownName, TakeBack } from "./share_dialog";

export interface LiveLineProps {
  readonly session: ViewerSession;
  readonly role: Role;
  /** Whether the scan belongs to the user, who may then present again at any time. */
  readonly owner: boolean;
}

/** For a follower: shows who is presenting, and the switch to a free camera. */
export function LiveLine({ session, role, owner }: LiveLineProps) {
  const presenter = role.presenter;
  return (
    <div class="glass live-line">
      <p role="status">{presenter ? t.live.presents(shownName(presenter)) : t.live.presenterAway}</p>
      {owner ? <TakeBack session={session} role={role} /> : null}
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
