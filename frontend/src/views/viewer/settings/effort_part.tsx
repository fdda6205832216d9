import * as effort from "../../../scene/effort";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { NumberControl, SelectControl, Switch } from "./controls";

interface EffortProps {
  readonly session: ViewerSession;
}

/** The stop condition of a picture, and the pictures that are shown until then. */
export function EffortPart({ session }: EffortProps) {
  const text = t.settings.effort;
  const now = session.effort.value;
  const set = (change: Partial<effort.Effort>) => session.setEffort({ ...now, ...change });
  return (
    <>
      <Switch label={text.smooth} on={now.smooth} change={(smooth) => set({ smooth })} />
      <SelectControl
        long
        label={text.stop}
        value={effort.stopOf(now)}
        options={effort.stops.map((one) => [one, text.stops[one]])}
        change={(stop) => session.setEffort(effort.stopping(now, stop))}
      />
      <StopLimit session={session} />
      <SelectControl
        label={text.moving}
        value={String(now.moving_scale)}
        options={effort.movingScales.map((scale) => [String(scale), text.scale(100 * scale)])}
        change={(scale) => set({ moving_scale: Number(scale) })}
      />
    </>
  );
}

/** The number of the chosen stop condition, if it has one. */
function StopLimit({ session }: EffortProps) {
  const text = t.settings.effort;
  const now = session.effort.value;
  const set = (change: Partial<effort.Effort>, held: boolean) => session.setEffort({ ...now, ...change }, held);
  const rest = () => session.keepEffort();
  switch (effort.stopOf(now)) {
    case "error":
      return (
        <NumberControl
          label={text.error}
          unit={t.settings.percent}
          value={100 * now.stop_error}
          limits={{ low: 100 * effort.stopErrorLimits.low, high: 100 * effort.stopErrorLimits.high }}
          slide={{ low: 1, high: 50 }}
          logarithmic
          step={0.5}
          rest={rest}
          change={(percent, held) => set({ stop_error: percent / 100 }, held)}
        />
      );
    case "samples":
      return (
        <NumberControl
          label={text.samples}
          value={now.stop_samples}
          limits={effort.stopSamplesLimits}
          slide={{ low: 1, high: 10_000 }}
          logarithmic
          rest={rest}
          change={(samples, held) => set({ stop_samples: Math.round(samples) }, held)}
        />
      );
    default:
      return null;
  }
}
