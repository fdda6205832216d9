import { useEffect, useState } from "preact/hooks";
import type { Role } from "../../live/role";
import type { Participant } from "../../protocol/messages";
import { tab } from "../../storage";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { colourOf } from "../picture/pointer_mark";
import { CopyField } from "../copy_field";
import { CloseButton, Dialog } from "../dialog";
import { useApp } from "../state";
import { Switch } from "./settings/controls";

export const shownName = (one: Participant): string => one.name || t.live.owner;

export function nameOf(people: readonly Participant[], number: number): string {
  const one = people.find((person) => person.number === number);
  return one ? shownName(one) : "";
}

export interface ShareDialogProps {
  readonly session: ViewerSession;
  readonly role: Role;
  readonly owner: boolean;
  readonly onClose: () => void;
}

/** The link with which others join, and the participants. */
export function ShareDialog({ session, role, owner, onClose }: ShareDialogProps) {
  const raised = role.people.filter(({ hand }) => hand > 0).length;
  return (
    <Dialog title={t.live.title} onClose={onClose}>
      {owner ? (
        <LinkPart session={session} role={role} />
      ) : (
        <p>{role.presents ? t.live.presenterLead : t.live.guestLead}</p>
      )}
      <h3>{t.live.here}</h3>
      <ul class="people">
        {role.people.map((one) => (
          <li key={one.id} data-participant={one.id}>
            <span class="people-name" data-colour={colourOf(one.number)}>
              {shownName(one)}
              {one.id === role.you ? <small>{t.live.you}</small> : null}
            </span>
            <small>
              {[
                one.presenter ? t.live.presenting : "",
                one.freeCamera ? t.live.withFreeCamera : "",
                one.hand > 0 ? t.live.hand(one.hand, raised) : "",
              ]
                .filter(Boolean)
                .join(", ")}
            </small>
            {role.presents && one.id !== role.you && !one.freeCamera ? (
              <button
                type="button"
                class="button"
                aria-label={t.live.letPresent(shownName(one))}
                onClick={() => session.handOver(one.id)}
              >
                {t.live.handOver}
              </button>
            ) : null}
          </li>
        ))}
      </ul>
      <GuestPointers session={session} role={role} />
      {role.presents && !role.guest && role.others > 0 ? <p class="field-hint">{t.live.handOverHint}</p> : null}
      {owner && role.follows ? (
        <p>
          <TakeBack session={session} role={role} />
        </p>
      ) : null}
      {session.problem.value ? (
        <p class="field-fault" role="alert">
          {session.problem.value}
        </p>
      ) : null}
      <CloseButton onClick={onClose} />
    </Dialog>
  );
}

const againAfterMs = 3000;

/**
 * The button with which only the owner presents again. An owner with a free camera first returns to
 * the picture that they will present.
 */
export function TakeBack({ session, role }: { readonly session: ViewerSession; readonly role: Role }) {
  const [taking, setTaking] = useState(false);
  const { you, freeCamera } = role;
  useEffect(() => {
    if (!taking) return;
    if (freeCamera) session.useFreeCamera(false);
    else session.handOver(you);
    const timer = setTimeout(() => setTaking(false), againAfterMs);
    return () => clearTimeout(timer);
  }, [taking, freeCamera, session, you]);
  return (
    <button type="button" class="button" disabled={taking} onClick={() => setTaking(true)}>
      {taking ? t.live.takingBack : t.live.takeBack}
    </button>
  );
}

/**
 * Returns the key of the link in this tab's storage. The server stores only the link's hash and
 * cannot show it again. The value is the path of the link, then " slices" if the link allows all
 * slices.
 */
const memory = (sessionId: string) => `diaphane.link.${sessionId}`;

/** The link with which others join, and their permissions. */
function LinkPart({ session, role }: { readonly session: ViewerSession; readonly role: Role }) {
  const [wide, setWide] = useState(false);
  const ended = () => {
    setWide(false);
    // Takes over, because a guest who was presenting has been disconnected.
    if (role.follows && !role.freeCamera) session.handOver(role.you);
  };
  const { url, allSlices, message, busy, make, end, copy } = useGuestLink(session.sessionId ?? "", ended);
  return (
    <div class="share-link">
      <p>{t.live.lead}</p>
      {url === null && session.audience.value?.setsGuestSlices ? (
        <>
          <Switch label={t.live.allSlices} on={wide} change={setWide} />
          <p class="field-hint">{t.live.allSlicesHint}</p>
        </>
      ) : null}
      {url === null ? (
        <p>
          <button
            type="button"
            class="button button-main"
            disabled={busy || session.sessionId === null || session.sessionId === ""}
            onClick={() => make(wide)}
          >
            {t.live.makeLink}
          </button>
        </p>
      ) : (
        <>
          <CopyField value={url} label={t.live.link} button={t.live.copy} onCopy={copy} />
          {allSlices ? <p class="field-hint">{t.live.withAllSlices}</p> : null}
          <p>
            <button type="button" class="button button-danger" disabled={busy} onClick={end}>
              {t.live.endLink}
            </button>
          </p>
        </>
      )}
      {allSlices ? null : <GuestSlices session={session} />}
      <p class="muted" role="status">
        {message}
      </p>
    </div>
  );
}

/** The link to a session, or null, and the actions on it. */
function useGuestLink(sessionId: string, ended: () => void) {
  const app = useApp();
  const [stored, setStored] = useState(() => tab.getItem(memory(sessionId)));
  const [message, setMessage] = useState("");
  const [busy, setBusy] = useState(false);
  const [path, wide] = stored?.split(" ") ?? [];
  const url = path === undefined ? null : location.origin + path;
  const act = (work: () => Promise<void>) => {
    setBusy(true);
    setMessage("");
    work()
      .catch((thrown: unknown) => setMessage(app.explain(thrown)))
      .finally(() => setBusy(false));
  };
  const make = (slices: boolean) =>
    act(async () => {
      const link = await app.api.createLink(sessionId, slices);
      const kept = link.path + (slices ? " slices" : "");
      tab.setItem(memory(sessionId), kept);
      setStored(kept);
    });
  const end = () =>
    act(async () => {
      await app.api.endLinks(sessionId);
      tab.removeItem(memory(sessionId));
      setStored(null);
      setMessage(t.live.ended);
      ended();
    });
  const copy = () =>
    act(async () => {
      await navigator.clipboard.writeText(url ?? "");
      setMessage(t.live.copied);
    });
  return { url, allSlices: wide !== undefined, message, busy, make, end, copy };
}

/** Explains how to point, and lets the presenter choose whether guests may point. */
function GuestPointers({ session, role }: { readonly session: ViewerSession; readonly role: Role }) {
  const audience = session.audience.value;
  if (!audience || role.others === 0) return null;
  return (
    <>
      {role.presents ? (
        <Switch
          label={t.live.guestPointers}
          on={audience.guestPointers}
          change={(on) => session.collaboration.setGuestPointers(on)}
        />
      ) : null}
      {session.collaboration.points.value ? <p class="field-hint">{t.live.pointHint}</p> : null}
    </>
  );
}

/** Lets the owner choose whether guests may see the slices. */
function GuestSlices({ session }: { readonly session: ViewerSession }) {
  const audience = session.audience.value;
  if (!audience?.setsGuestSlices) return null;
  return (
    <>
      <Switch label={t.live.guestSlices} on={audience.guestSlices} change={(on) => session.setGuestSlices(on)} />
      <p class="field-hint">{t.live.guestSlicesHint}</p>
    </>
  );
}
