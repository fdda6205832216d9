import { effect, signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { recording_path, type Api } from "../../api/client";
import type { Recordings } from "../../api/types";
import { Recorder, type Recording } from "../../live/recorder";
import { role_of } from "../../live/role";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Dialog } from "../dialog";
import { useApp } from "../state";

/** Whether this person's interaction is recorded: nothing until the server has said it. */
const consent = signal(false);
/** What may be sent while a page goes. */
const most_while_leaving = 60_000;

/** Records how the picture is looked at, for as long as the person consents. Shows nothing. */
export function RecordedInteraction({ session }: { readonly session: ViewerSession }) {
  const { api } = useApp();
  useEffect(() => {
    api.recordings().then((mine) => (consent.value = mine.consent), () => undefined);
  }, [api]);
  useEffect(() => {
    const leaving = new AbortController();
    const recorder = new Recorder();
    const stop = effect(() => {
      const scene = session.scene.value;
      const others = !role_of(session.audience.value).presents; // somebody else's hand, who was not asked
      if (!consent.value || others) recorder.take(session.viewport); // forgotten
      else if (scene) keep(api, recorder.add(scene, performance.now(), session.viewport), false);
    });
    const last = () => keep(api, recorder.take(session.viewport), true);
    addEventListener("pagehide", last, { signal: leaving.signal });
    return () => {
      stop();
      leaving.abort();
      last();
    };
  }, [api, session]);
  return null;
}

function keep(api: Api, recording: Recording | null, leaving: boolean): void {
  if (!recording) return;
  const small = !leaving || JSON.stringify(recording).length < most_while_leaving;
  void api.keep_recording(recording, leaving && small).catch(() => undefined);
}

/** The switch, and what there is. */
export function RecordingDialog({ onClose }: { readonly onClose: () => void }) {
  const app = useApp();
  const [mine, set_mine] = useState<Recordings | null>(null);
  const [said, set_said] = useState("");
  const load = () => app.api.recordings().then(
    (now) => {
      set_mine(now);
      consent.value = now.consent;
    },
    (thrown: unknown) => set_said(app.explain(thrown)),
  );
  useEffect(() => void load(), []);
  const change = (work: Promise<void>, undo?: () => void) => {
    set_said("");
    void work.then(load, (thrown: unknown) => {
      undo?.();
      set_said(app.explain(thrown));
    });
  };
  /** The switch stands where it was put until the server has said otherwise, however often this is drawn meanwhile. */
  const agree = (now: Recordings, wanted: boolean) => {
    set_mine({ ...now, consent: wanted });
    change(app.api.record_interaction(wanted), () => set_mine(now));
  };
  return (
    <Dialog title={t.recording.title} onClose={onClose}>
      <p>{t.recording.lead}</p>
      <label class="switch">
        <input
          type="checkbox"
          role="switch"
          checked={mine?.consent ?? false}
          disabled={mine === null}
          onChange={(event) => mine && agree(mine, event.currentTarget.checked)}
        />
        <span>{t.recording.consent}</span>
      </label>
      {mine && mine.items.length > 0 ? (
        <ul class="people">
          {mine.items.map((one) => (
            <li key={one.id}>
              <span class="people-name">{t.recording.item(one.duration_ms / 1000, one.events)}</span>
              <a class="button" href={recording_path(one.id)} download="interaction.json">{t.recording.export_one}</a>
              <button type="button" class="button" onClick={() => change(app.api.delete_recording(one.id))}>{t.recording.delete_one}</button>
            </li>
          ))}
        </ul>
      ) : null}
      {said ? <p class="field-fault" role="alert">{said}</p> : null}
      <div class="dialog-buttons">
        <button type="button" class="button button-main" onClick={onClose}>{t.close}</button>
      </div>
    </Dialog>
  );
}
