import type { ComponentChildren, JSX } from "preact";
import { useRef } from "preact/hooks";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Icon } from "../icons";
import { Link } from "../router";
import type { Trouble } from "../../protocol/connection";
import { useApp } from "../state";
import { Announcer } from "./announcer";
import { PictureTimeOver } from "./picture_time";
import { VisitOver, wayBack, type Visitor } from "./visitor";

export interface StatusLineProps {
  readonly session: ViewerSession | null;
  readonly fault: string;
  readonly visitor: Visitor | undefined;
  /** Further text below the message. */
  readonly children: ComponentChildren;
}

/** The reason for a missing or outdated picture, and notes. A screen reader announces their texts. */
export function StatusLine({ session, fault, visitor, children }: StatusLineProps) {
  const app = useApp();
  const lines = useRef<HTMLDivElement>(null);
  const connection = session?.connection.value;
  const trouble = connection?.trouble ?? null;
  const shown = session?.pictures.picture.value ?? null;
  const elsewhere = connection?.phase === "elsewhere";
  const stopped = connection?.phase === "stopped" || elsewhere;
  // Shows the server's own message for a rejection, if there is one.
  const message = session?.problem.value ?? "";
  const said =
    [fault, trouble === "refused" ? message : "", trouble ? t.viewer.troubles[trouble] : "", message].find(
      (line) => line !== "",
    ) ?? "";
  const isLate = said === "" && (session?.answers.late.value ?? false);
  const text = isLate ? t.viewer.late : said;
  const meanwhile = shown && ((trouble && !stopped) || isLate) ? t.viewer.meanwhile : "";
  const over = overOf(trouble, visitor);
  const ownView = session?.ownView.coming.value ?? false;
  // Slices alone need no picture, and nothing may cover them.
  const wanted = session?.slices.pictureShown.value ?? true;
  return (
    <>
      <Announcer of={lines} />
      <div
        class={`viewer-status${(wanted && shown === null) || over !== null ? " viewer-status-middle" : ""}`}
        ref={lines}
        data-phase={connection?.phase ?? "idle"}
      >
        {over ?? (
          <StatusMessage
            waiting={text === "" && wanted && (shown === null || ownView)}
            ownView={ownView}
            bad={(!trouble && !isLate) || stopped}
            text={[text, meanwhile]}
          >
            {elsewhere ? (
              <button type="button" class="button" onClick={() => session?.start()}>
                {t.viewer.continueHere}
              </button>
            ) : trouble === "signed_out" ? (
              <button type="button" class="button" onClick={() => (app.me.value = null)}>
                {t.account.signIn}
              </button>
            ) : stopped ? (
              <Link href={wayBack(visitor).href}>{wayBack(visitor).text}</Link>
            ) : null}
          </StatusMessage>
        )}
        {over ? null : children}
      </div>
    </>
  );
}

/** Returns the panel that permanently replaces the picture, if there is one. */
function overOf(trouble: Trouble | null, visitor: Visitor | undefined): JSX.Element | null {
  if (trouble === "time_spent") return <PictureTimeOver />;
  return visitor && trouble === "link_ended" ? <VisitOver visitor={visitor} /> : null;
}

interface StatusMessageProps {
  /** Whether nothing is wrong, but there is no picture yet. */
  readonly waiting: boolean;
  /** Whether the picture that is prepared is a follower's own view. */
  readonly ownView: boolean;
  /** Whether the message stays until the user acts. */
  readonly bad: boolean;
  readonly text: readonly string[];
  /** The buttons below the message. */
  readonly children: ComponentChildren;
}

function StatusMessage({ waiting, ownView, bad, text, children }: StatusMessageProps) {
  const message = text.filter(Boolean).join(" ");
  if (waiting)
    return (
      <p class={`glass pill${ownView ? " pill-soon" : ""}`}>
        <span class="spinner" />
        <span data-said>{ownView ? t.live.ownViewComing : t.viewer.first}</span>
      </p>
    );
  if (message === "") return null;
  return (
    <p class={`glass pill${bad ? " pill-bad" : " pill-warn"}`}>
      {bad ? <Icon name="alert" /> : <span class="spinner" />}
      <span data-said>{message}</span>
      {children}
    </p>
  );
}
