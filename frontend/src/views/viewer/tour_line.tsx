import { useEffect } from "preact/hooks";
import { t } from "../../texts";
import type { Role } from "../../live/role";
import { maySaveVideos } from "./viewer_dialogs";
import type { TourState } from "../../video/tour";
import type { ViewerSession } from "../../video/viewer_session";

export interface TourLineProps {
  readonly session: ViewerSession;
  readonly role: Role;
  /** Puts the focus on the picture, because the focused button goes away. */
  readonly onHide: () => void;
  /** Opens the form for a video of the tour. */
  readonly onVideo: () => void;
}

/** The state of the tour, with its controls. Escape stops the tour from anywhere on the page. */
export function TourLine({ session, role, onHide, onVideo }: TourLineProps) {
  const { tour } = session.guide;
  const state = tour.state.value;
  const fault = tour.fault.value;
  const text = t.settings.view;
  useStopKey(session, state !== "off");
  if (!role.presents || (state === "off" && fault === null)) return null;
  if (state === "off")
    return (
      <p class="glass pill tour-line">
        <span data-said>{text[fault ?? "unanswered"]}</span>
        <button
          type="button"
          class="button button-small"
          onClick={() => {
            tour.fault.value = null;
            onHide();
          }}
        >
          {t.close}
        </button>
      </p>
    );
  return (
    <p class="glass pill tour-line" data-tour={state}>
      <span data-said>{progressOf(session, state)}</span>
      <span class="tour-buttons">
        {state === "asking" ? null : (
          <button type="button" class="button button-small" onClick={() => tour.pauseOrContinue()}>
            {state === "paused" ? text.goOn : text.pause}
          </button>
        )}
        <button
          type="button"
          class="button button-small"
          onClick={() => {
            tour.stop();
            onHide();
          }}
        >
          {text.stop}
        </button>
        {state === "asking" || !maySaveVideos(session, role) ? null : (
          <button
            type="button"
            class="button button-small"
            onClick={() => {
              if (state === "moving") tour.pauseOrContinue();
              onVideo();
            }}
          >
            {text.video}
          </button>
        )}
      </span>
    </p>
  );
}

function progressOf(session: ViewerSession, state: TourState): string {
  const text = t.settings.view;
  if (state === "asking") return text.looking;
  if (state === "paused") return text.paused;
  return session.connection.value.phase === "live" ? text.touring : text.waits;
}

function useStopKey(session: ViewerSession, active: boolean): void {
  useEffect(() => {
    if (!active) return;
    const pressed = (event: KeyboardEvent) => {
      if (event.key !== "Escape" || event.defaultPrevented || document.querySelector("dialog[open]")) return;
      event.preventDefault();
      session.guide.tour.stop();
    };
    // Before a window takes the key to close itself.
    addEventListener("keydown", pressed, true);
    return () => removeEventListener("keydown", pressed, true);
  }, [session, active]);
}
