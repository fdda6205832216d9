import type { Role } from "../../live/role";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { IconButton } from "../icon_button";
import { Icon } from "../icons";
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
      <p role="status">
        {presenter ? t.live.presents(shownName(presenter)) : t.live.presenterAway}
        {presenter || owner || role.freeCamera ? null : ` ${t.live.lookAround}`}
        {presenter && !role.freeCamera ? <Notes session={session} owner={owner} /> : null}
      </p>
      {owner ? <TakeBack session={session} role={role} /> : null}
      <HandButton session={session} role={role} />
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

/** What a follower can do if the picture is not as they want it. */
function Notes({ session, owner }: Pick<LiveLineProps, "session" | "owner">) {
  return (
    <>
      {owner ? null : <span class="live-note">{t.live.turnIt}</span>}
      {isWide(session) ? <span class="live-note live-turn">{t.live.turnPhone}</span> : null}
    </>
  );
}

/**
 * Whether the presenter's window is so wide that a phone held upright shows its picture very small.
 */
function isWide(session: ViewerSession): boolean {
  const shown = session.pictures.picture.value;
  return shown !== null && shown.width > 1.3 * shown.height;
}

function HandButton({ session, role }: Pick<LiveLineProps, "session" | "role">) {
  const raised = role.people.some(({ id, hand }) => id === role.you && hand > 0);
  const label = raised ? t.live.lowerHand : t.live.raiseHand;
  return (
    <button
      type="button"
      class="button live-hand"
      aria-label={label}
      title={label}
      aria-pressed={raised}
      onClick={() => session.raiseHand(!raised)}
    >
      <Icon name="hand" />
    </button>
  );
}

/** For the presenter: who raised their hand, in order, and how to lower it. */
export function RaisedHands({ session, role }: Pick<LiveLineProps, "session" | "role">) {
  const raised = role.people.filter(({ hand }) => hand > 0).sort((a, b) => a.hand - b.hand);
  const [first] = raised;
  return (
    <div class={first ? "glass pill hands" : "visually-hidden"}>
      <p role="status">
        {first ? (
          <>
            <Icon name="hand" /> {t.live.handsRaised(raised.map(shownName).join(", "))}
          </>
        ) : null}
      </p>
      {first ? (
        <>
          <button type="button" class="button button-small" onClick={() => session.handOver(first.id)}>
            {t.live.letPresent(shownName(first))}
          </button>
          <IconButton
            icon="close"
            label={t.live.lowerHandOf(shownName(first))}
            onClick={() => session.raiseHand(false, first.id)}
          />
        </>
      ) : null}
    </div>
  );
}
