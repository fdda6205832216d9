import { effect, signal } from "@preact/signals";
import { useCallback, useEffect, useState } from "preact/hooks";
import { recordingPath, type Api } from "../../api/client";
import type { Recordings } from "../../api/types";
import { Recorder, type Recording } from "../../live/recorder";
import { roleOf } from "../../live/role";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { CloseButton, Dialog } from "../dialog";
import { useApp } from "../state";

/** Whether the user's interaction is recorded. False until the server has responded. */
const consent = signal(false);
/** The maximum size of a request while a page closes. */
const mostWhileLeaving = 60_000;

/** Records the user's interaction while the user consents. Shows nothing. */
export function RecordedInteraction({ session }: { readonly session: ViewerSession }) {
  const { api } = useApp();
  useEffect(() => {
    consent.value = false; // what another user of this tab agreed to does not count
    api.recordings().then(
      (mine) => (consent.value = mine.consent),
      () => undefined,
    );
  }, [api]);
  useEffect(() => {
    const leaving = new AbortController();
    const recorder = new Recorder();
    const stop = effect(() => {
      const scene = session.editor.scene.value;
      const others = !roleOf(session.audience.value).presents; // the presenter gave no consent
      if (!consent.value || others)
        recorder.take(session.viewport); // discards the events so far
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
  const small = !leaving || JSON.stringify(recording).length < mostWhileLeaving;
  void api.keepRecording(recording, leaving && small).catch(() => undefined);
}

/** The consent to recording, and the recordings that exist. */
export function RecordingDialog({ onClose }: { readonly onClose: () => void }) {
  const { mine, message, agree, remove } = useRecordings();
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
      {mine && mine.items.length > 0 ? <RecordingList items={mine.items} remove={remove} /> : null}
      {message ? (
        <p class="field-fault" role="alert">
          {message}
        </p>
      ) : null}
      <CloseButton onClick={onClose} />
    </Dialog>
  );
}

/** The user's consent and recordings. They are read again after each change. */
function useRecordings() {
  const app = useApp();
  const [mine, setMine] = useState<Recordings | null>(null);
  const [message, setMessage] = useState("");
  const load = useCallback(
    () =>
      app.api.recordings().then(
        (now) => {
          setMine(now);
          consent.value = now.consent;
        },
        (thrown: unknown) => setMessage(app.explain(thrown)),
      ),
    [app],
  );
  useEffect(() => void load(), [load]);
  const change = (work: Promise<void>, undo?: () => void) => {
    setMessage("");
    void work.then(load, (thrown: unknown) => {
      undo?.();
      setMessage(app.explain(thrown));
    });
  };
  /** Changes the consent. The switch moves at once, and moves back only if the server refuses. */
  const agree = (now: Recordings, consent: boolean) => {
    setMine({ ...now, consent });
    change(app.api.recordInteraction(consent), () => setMine(now));
  };
  const remove = (id: string) => change(app.api.deleteRecording(id));
  return { mine, message, agree, remove };
}

interface RecordingListProps {
  readonly items: Recordings["items"];
  readonly remove: (id: string) => void;
}

function RecordingList({ items, remove }: RecordingListProps) {
  return (
    <ul class="people">
      {items.map((one) => (
        <li key={one.id}>
          <span class="people-name">{t.recording.item(one.duration_ms / 1000, one.events)}</span>
          <a class="button" href={recordingPath(one.id)} download="interaction.json">
            {t.recording.exportOne}
          </a>
          <button type="button" class="button" onClick={() => remove(one.id)}>
            {t.recording.deleteOne}
          </button>
        </li>
      ))}
    </ul>
  );
}
