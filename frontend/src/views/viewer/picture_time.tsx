import { useEffect, useState } from "preact/hooks";
import { pollDelayMs, pictureTime } from "../../api/picture_time";
import type { Me } from "../../api/types";
import { t } from "../../texts";
import { dayText, timeText } from "../format";
import { Icon } from "../icons";
import { Link } from "../router";
import { useApp } from "../state";
import { OverPanel } from "./over_panel";

const unansweredAgainMs = 30_000;

/**
 * Says how much rendering time is left this month, before it runs out and during the grace period of an open picture.
 */
export function PictureTimeLine({ onHide }: { readonly onHide: () => void }) {
  const time = useRenderTime();
  const [hidden, setHidden] = useState("");
  if (!time) return null;
  const state = pictureTime(time);
  if (state.kind === "enough") return null;
  if (state.kind === "ending")
    return (
      <p class="glass pill pill-bad">
        <Icon name="clock" />
        <span data-said>{t.viewer.pictureTime.ending(timeText(state.atMs), dayText(time.renewed_at))}</span>
      </p>
    );
  const key = state.minutes > 1 ? "minutes" : "last";
  if (hidden === key) return null;
  return (
    <p class="glass pill pill-time">
      <Icon name="clock" />
      <span data-said>{t.viewer.pictureTime.soon(state.minutes)}</span>
      <button
        type="button"
        class="icon-button"
        aria-label={t.viewer.pictureTime.hide}
        title={t.viewer.pictureTime.hide}
        onClick={() => {
          setHidden(key);
          onHide();
        }}
      >
        <Icon name="close" />
      </button>
    </p>
  );
}

/** Replaces the picture when there is no rendering time left. */
export function PictureTimeOver() {
  const renewedAt = useApp().me.value?.render_time.renewed_at;
  const text = t.viewer.pictureTime;
  return (
    <OverPanel
      heading={text.over}
      text={
        <>
          <p data-said>{renewedAt ? text.overText(dayText(renewedAt)) : text.overBefore}</p>
          <p class="muted" data-said>
            {text.more}
          </p>
        </>
      }
    >
      <Link href="/scans" class="button button-main">
        {t.viewer.back}
      </Link>
      <Link href="/account" class="button">
        {text.account}
      </Link>
    </OverPanel>
  );
}

/**
 * The rendering time as the server counts it. The less time is left, the more often it is
 * requested.
 */
function useRenderTime(): Me["render_time"] | null {
  const app = useApp();
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let here = true;
    const ask = async (): Promise<void> => {
      let waitMs = unansweredAgainMs;
      try {
        const me = await app.api.me();
        if (!here) return;
        if (me) {
          app.me.value = me;
          waitMs = pollDelayMs(me.render_time);
        }
      } catch {
        // The stream reports the problem.
      }
      if (here) timer = setTimeout(() => void ask(), waitMs);
    };
    void ask();
    return () => {
      here = false;
      clearTimeout(timer);
    };
  }, [app]);
  return app.me.value?.render_time ?? null;
}
