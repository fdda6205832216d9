import { useEffect, useState } from "preact/hooks";
import type { Role } from "../../live/role";
import type { Participant } from "../../protocol/messages";
import { tab } from "../../storage";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Dialog } from "../dialog";
import { Icon } from "../icons";
import { useApp } from "../state";
import { Switch } from "./settings/controls";

export const shown_name = (one: Participant): string => one.name || t.live.owner;

export interface ShareDialogProps {
  readonly session: ViewerSession;
  readonly role: Role;
  readonly owner: boolean;
  readonly onClose: () => void;
}

/** The link by which others join, and who is here. */
export function ShareDialog({ session, role, owner, onClose }: ShareDialogProps) {
  return (
    <Dialog title={t.live.title} onClose={onClose}>
      {owner ? <LinkPart session={session} /> : <p>{t.live.guest_lead}</p>}
      <h3>{t.live.here}</h3>
      <ul class="people">
        {role.people.map((one) => (
          <li key={one.id} data-participant={one.id}>
            <span class="people-name">
              {shown_name(one)}
              {one.id === role.you ? <small>{t.live.you}</small> : null}
            </span>
            <small>{[one.presenter ? t.live.presenting : "", one.ownCamera ? t.live.with_own_camera : ""].filter(Boolean).join(", ")}</small>
            {role.presents && one.id !== role.you && !one.ownCamera ? (
              <button type="button" class="button" aria-label={t.live.let_present(shown_name(one))} onClick={() => session.hand_over(one.id)}>
                {t.live.hand_over}
              </button>
            ) : null}
          </li>
        ))}
      </ul>
      {role.presents && !role.guest && role.others > 0 ? <p class="field-hint">{t.live.hand_over_hint}</p> : null}
      {owner && role.follows && role.presenter === null ? <TakeBack session={session} you={role.you} /> : null}
      {session.problem.value && role.presenter !== null ? <p class="field-fault" role="alert">{session.problem.value}</p> : null}
      <div class="dialog-buttons">
        <button type="button" class="button button-main" onClick={onClose}>{t.close}</button>
      </div>
    </Dialog>
  );
}

const asked_again_every_ms = 1000;

/** The server gives the role back once the presenter has been away for longer than a reload takes. */
function TakeBack({ session, you }: { readonly session: ViewerSession; readonly you: string }) {
  const [taking, set_taking] = useState(false);
  useEffect(() => {
    if (!taking) return;
    session.hand_over(you);
    const timer = setInterval(() => session.hand_over(you), asked_again_every_ms);
    return () => clearInterval(timer);
  }, [taking, session, you]);
  return (
    <p>
      <button type="button" class="button" disabled={taking} onClick={() => set_taking(true)}>
        {taking ? t.live.taking_back : t.live.take_back}
      </button>
    </p>
  );
}

/** Kept for this tab: the server has a hash of it and could not show it again. */
const memory = (session_id: string) => `diaphane.link.${session_id}`;

function LinkPart({ session }: { readonly session: ViewerSession }) {
  const app = useApp();
  const id = session.session_id ?? "";
  const [path, set_path] = useState(() => tab.getItem(memory(id)));
  const [said, set_said] = useState("");
  const [busy, set_busy] = useState(false);
  const audience = session.audience.value;
  const url = path === null ? "" : location.origin + path;

  const act = (work: () => Promise<void>) => {
    set_busy(true);
    set_said("");
    work().catch((thrown: unknown) => set_said(app.explain(thrown))).finally(() => set_busy(false));
  };
  const make = () => act(async () => {
    const link = await app.api.create_link(id);
    tab.setItem(memory(id), link.path);
    set_path(link.path);
  });
  const end = () => act(async () => {
    await app.api.end_links(id);
    tab.removeItem(memory(id));
    set_path(null);
    set_said(t.live.ended);
  });
  const copy = () => act(async () => {
    await navigator.clipboard.writeText(url);
    set_said(t.live.copied);
  });
  return (
    <div class="share-link">
      <p>{t.live.lead}</p>
      {path === null ? (
        <p><button type="button" class="button button-main" disabled={busy || id === ""} onClick={make}>{t.live.make_link}</button></p>
      ) : (
        <>
          <div class="share-row">
            <input type="text" readOnly value={url} aria-label={t.live.link} onFocus={(event) => event.currentTarget.select()} />
            <button type="button" class="button" onClick={copy}><Icon name="copy" />{t.live.copy}</button>
          </div>
          <p><button type="button" class="button button-danger" disabled={busy} onClick={end}>{t.live.end_link}</button></p>
        </>
      )}
      {audience?.setsGuestSlices ? (
        <>
          <Switch label={t.live.guest_slices} on={audience.guestSlices} change={(on) => session.set_guest_slices(on)} />
          <p class="field-hint">{t.live.guest_slices_hint}</p>
        </>
      ) : null}
      <p class="muted" role="status">{said}</p>
    </div>
  );
}
