import { effect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type { KeyCommand } from "../../input/keys";
import { Recorder, type Recording } from "../../live/recorder";
import type { Place } from "../../live/place";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { useKeyCommands } from "../viewer/use_key_commands";
import { useViewerSession } from "../viewer/use_viewer_session";

export interface LivePictureProps {
  readonly place: Place;
  /** Whether the picture can be turned. */
  readonly turns: boolean;
  /** Whether a key shows the first view again. In a task about views, it would be the answer. */
  readonly resets?: boolean;
  /** Whether the picture is hidden for now. */
  readonly covered?: boolean;
  readonly onSession: (session: ViewerSession) => void;
  /** Called with each recording of the interaction, if it is recorded. */
  readonly onRecording?: ((recording: Recording) => void) | undefined;
  /** Called to begin again with the picture after an interruption. */
  readonly onAgain: () => void;
  /** Elements over the picture. */
  readonly children?: ComponentChildren;
}

/** A live picture without the menus of the viewer. */
export function LivePicture(props: LivePictureProps) {
  const { place, turns, covered = false, resets = true, onSession, onRecording, onAgain, children } = props;
  const canvas = useRef<HTMLCanvasElement>(null);
  const { session, fault } = useViewerSession(place, canvas);
  useEffect(() => {
    if (session) onSession(session);
    // eslint-disable-next-line react-hooks/exhaustive-deps -- the callback is new in each render
  }, [session]);
  useRecording(session, onRecording);
  useKeyCommands((command: KeyCommand) => {
    if (!session) return;
    if (command.kind === "gesture") session.editor.act(command.gesture);
    if (command.kind === "reset" && resets) session.editor.resetCamera();
  }, turns && !covered);
  const shown = session?.pictures.picture.value ?? null;
  return (
    <div class="study-picture" data-covered={covered || shown === null ? "" : undefined}>
      <div class="stage" data-still={turns ? undefined : ""}>
        <canvas
          ref={canvas}
          tabIndex={turns ? 0 : -1}
          role={turns ? "application" : "img"}
          aria-label={turns ? `${t.takePart.live}. ${t.takePart.hint}` : t.takePart.live}
          {...(shown ? { "data-samples": String(shown.samples), "data-input-seq": String(shown.inputSeq) } : {})}
        />
      </div>
      <PictureState session={session} fault={fault} onAgain={onAgain} />
      {children}
    </div>
  );
}

interface PictureStateProps {
  readonly session: ViewerSession | null;
  readonly fault: string;
  readonly onAgain: () => void;
}

/** The reason for a missing or outdated picture, in words for participants. */
function PictureState({ session, fault, onAgain }: PictureStateProps) {
  const connection = session?.connection.value;
  const trouble = connection?.trouble ?? null;
  const isStopped = connection?.phase === "stopped" || connection?.phase === "elsewhere";
  const isWaiting = session?.pictures.picture.value == null && !fault;
  const busy = trouble === "no_worker" || trouble === "guests_full";
  const text =
    fault ||
    (trouble === "time_spent"
      ? t.takePart.pictureSpent
      : busy
        ? t.takePart.pictureBusy
        : isStopped
          ? t.takePart.pictureOver
          : trouble
            ? t.viewer.troubles[trouble]
            : isWaiting
              ? t.viewer.first
              : "");
  return (
    <div class="study-picture-state" role="status">
      {text ? (
        <p class="glass pill">
          {isStopped || fault ? null : <span class="spinner" />}
          {text}
          {isStopped ? (
            <button type="button" class="button button-small" onClick={onAgain}>
              {t.takePart.pictureAgain}
            </button>
          ) : null}
        </p>
      ) : null}
    </div>
  );
}

/** Records the interaction of a participant who has agreed to it. */
function useRecording(session: ViewerSession | null, onRecording: LivePictureProps["onRecording"]): void {
  const latest = useRef(onRecording);
  latest.current = onRecording;
  useEffect(() => {
    if (!session || !latest.current) return;
    const recorder = new Recorder();
    const keep = (recording: Recording | null) => {
      if (recording) latest.current?.(recording);
    };
    const stop = effect(() => {
      const scene = session.editor.scene.value;
      if (scene) keep(recorder.add(scene, performance.now(), session.viewport));
    });
    const last = () => keep(recorder.take(session.viewport));
    addEventListener("pagehide", last);
    return () => {
      stop();
      removeEventListener("pagehide", last);
      last();
    };
  }, [session]);
}
