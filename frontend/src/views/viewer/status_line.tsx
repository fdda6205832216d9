import type { ComponentChildren } from "preact";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Icon } from "../icons";
import { Link } from "../router";
import { PictureTimeOver } from "./picture_time";

export interface StatusLineProps {
  readonly session: ViewerSession | null;
  readonly fault: string;
  /** What else there is to say, below. */
  readonly children: ComponentChildren;
}

/** Why there is no picture, or no new one: said in words, and read out. */
export function StatusLine({ session, fault, children }: StatusLineProps) {
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
  const over = trouble === "time_spent";
  const waiting = text === "" && shown === null;
  return (
    <div
      class={`viewer-status${shown === null || over ? " viewer-status-middle" : ""}`}
      role="status"
      data-phase={connection?.phase ?? "idle"}
    >
      {over ? (
        <PictureTimeOver />
      ) : waiting ? (
        <p class="glass pill">
          <span class="spinner" />
          {t.viewer.first}
        </p>
      ) : text ? (
        <p class={`glass pill${trouble && !stopped ? " pill-warn" : " pill-bad"}`}>
          {trouble && !stopped ? <span class="spinner" /> : <Icon name="alert" />}
          {[text, meanwhile].filter(Boolean).join(" ")}
          {elsewhere ? (
            <button type="button" class="button" onClick={() => session?.start()}>
              {t.viewer.continueHere}
            </button>
          ) : stopped ? (
            <Link href="/scans">{t.viewer.back}</Link>
          ) : null}
        </p>
      ) : null}
      {over ? null : children}
    </div>
  );
}
