import * as effort from "../../../scene/effort";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { NumberControl, Switch } from "./controls";

/** When a picture is good enough, and what is shown until then. */
export function EffortPart({ session }: { readonly session: ViewerSession }) {
  const text = t.settings.effort;
  const now = session.effort.value;
  const stop = effort.stop_of(now);
  const set = (change: Partial<effort.Effort>, held = false) => session.set_effort({ ...now, ...change }, held);
  const done = () => session.keep_effort();
  return (
    <>
      <Switch label={text.smooth} on={now.smooth} change={(smooth) => set({ smooth })} />
      <label class="control">
        <span class="control-name">{text.stop}</span>
        <select class="choice" value={stop} onChange={(event) => {
          const chosen = effort.stops.find((one) => one === event.currentTarget.value);
          if (chosen) session.set_effort(effort.stopping(now, chosen));
        }}>
          {effort.stops.map((one) => <option key={one} value={one}>{text.stops[one]}</option>)}
        </select>
      </label>
      {stop === "error" ? (
        <NumberControl label={text.error} unit={t.settings.percent} value={100 * now.stop_error} limits={{ low: 100 * effort.stop_error_limits.low, high: 100 * effort.stop_error_limits.high }}
          slide={{ low: 1, high: 50 }} logarithmic step={0.5} rest={done} change={(percent, held) => set({ stop_error: percent / 100 }, held)} />
      ) : null}
      {stop === "samples" ? (
        <NumberControl label={text.samples} value={now.stop_samples} limits={effort.stop_samples_limits} slide={{ low: 1, high: 10_000 }} logarithmic rest={done}
          change={(samples, held) => set({ stop_samples: Math.round(samples) }, held)} />
      ) : null}
      <label class="control">
        <span class="control-name">{text.moving}</span>
        <select class="choice" value={String(now.moving_scale)} onChange={(event) => {
          const scale = Number(event.currentTarget.value);
          set({ moving_scale: scale });
        }}>
          {effort.moving_scales.map((scale) => <option key={scale} value={String(scale)}>{text.scale(100 * scale)}</option>)}
        </select>
      </label>
    </>
  );
}
