import type { ComponentChildren, JSX } from "preact";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Icon } from "../icons";
import { Link } from "../router";
import type { Trouble } from "../../protocol/connection";
import { PictureTimeOver } from "./picture_time";
import { VisitOver, wayBack, type Visitor } from "./visitor";

export interface StatusLineProps {
  readonly session: ViewerSession | null;
  readonly fault: string;
  readonly visitor: Visitor | undefined;
  /** What else there is to say, below. */
  readonly children: ComponentChildren;
}

/** Why there is no picture, or no new one: said in words, and read out. */
export function StatusLine({ session, fault, visitor, children }: StatusLineProps) {
  const connection = session?.connection.value;
  const trouble = connection?.trouble ?? null;
  const shown = session?.pictures.picture.value ?? null;
  const elsewhere = connection?.phase === "elsewhere";
  const stopped = connection?.phase === "stopped" || elsewhere;
  // Shows the server's own message for a rejection, if there is one.
  const said = session?.problem.value ?? "";
  const text =
    [fault, trouble === "refused" ? said : "", trouble ? t.viewer.troubles[trouble] : "", said].find(
      (line) => line !== "",
    ) ?? "";
  const meanwhile = shown && trouble && !stopped ? t.viewer.meanwhile : "";
  const over = overOf(trouble, visitor);
  return (
    <div
      class={`viewer-status${shown === null || over !== null ? " viewer-status-middle" : ""}`}
      role="status"
      data-phase={connection?.phase ?? "idle"}
    >
      {over ?? (
        <Said waiting={text === "" && shown === null} bad={!trouble || stopped} text={[text, meanwhile]}>
          {elsewhere ? (
            <button type="button" class="button" onClick={() => session?.start()}>
              {t.viewer.continueHere}
            </button>
          ) : stopped ? (
            <Link href={visitor ? wayBack(visitor) : "/scans"}>{visitor ? t.viewer.visitor.back : t.viewer.back}</Link>
          ) : null}
        </Said>
      )}
      {over ? null : children}
    </div>
  );
}

/** What replaces the picture for good, if anything does. */
function overOf(trouble: Trouble | null, visitor: Visitor | undefined): JSX.Element | null {
  if (trouble === "time_spent") return <PictureTimeOver />;
  return visitor && trouble === "link_ended" ? <VisitOver visitor={visitor} /> : null;
}

interface SaidProps {
  /** Nothing is wrong, but there is no picture yet. */
  readonly waiting: boolean;
  /** What is said does not pass by itself. */
  readonly bad: boolean;
  readonly text: readonly string[];
  /** What can be pressed. */
  readonly children: ComponentChildren;
}

function Said({ waiting, bad, text, children }: SaidProps) {
  const said = text.filter(Boolean).join(" ");
  if (waiting)
    return (
      <p class="glass pill">
        <span class="spinner" />
        {t.viewer.first}
      </p>
    );
  if (said === "") return null;
  return (
    <p class={`glass pill${bad ? " pill-bad" : " pill-warn"}`}>
      {bad ? <Icon name="alert" /> : <span class="spinner" />}
      {said}
      {children}
    </p>
  );
}
