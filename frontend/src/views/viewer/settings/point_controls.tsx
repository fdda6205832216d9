import type { Channel } from "../../../protocol/gen/api/proto/scene_pb";
import type { Limits } from "../../../scene/numbers";
import * as transfer from "../../../scene/transfer";
import { t } from "../../../texts";
import { Icon } from "../../icons";
import { NumberControl } from "./controls";

/** The chosen point of a channel, and the handlers that change it. */
export interface PointActs {
  readonly point: number;
  readonly range: Limits;
  readonly choose: (point: number) => void;
  readonly move: (point: number, value: number, opacity: number, held: boolean) => void;
  readonly rest: () => void;
  readonly remove: () => void;
}

export interface PointControlsProps extends PointActs {
  readonly channel: Channel;
  readonly unit: string;
  readonly add: () => void;
}

/** One point in numbers. */
export function PointControls({ channel, point, unit, range, choose, move, rest, add, remove }: PointControlsProps) {
  const text = t.settings.look;
  const { value = 0, opacity = 0 } = channel.opacity[point] ?? {};
  const all = channel.opacity.length;
  const limits = transfer.pointLimits(channel, point);
  const slide = { low: Math.max(limits.low, range.low), high: Math.min(limits.high, range.high) };
  const button = (icon: "left" | "right" | "plus" | "trash", label: string, possible: boolean, act: () => void) => (
    <button
      type="button"
      class="icon-button"
      aria-label={label}
      title={label}
      aria-disabled={!possible}
      onClick={() => {
        if (possible) act();
      }}
    >
      <Icon name={icon} />
    </button>
  );
  return (
    <div class="point" role="group" aria-label={text.point(point + 1, all)}>
      <p class="point-head">
        <strong>{text.point(point + 1, all)}</strong>
        {button("left", text.previous, point > 0, () => choose(point - 1))}
        {button("right", text.next, point < all - 1, () => choose(point + 1))}
        {button("plus", text.addPoint, all < transfer.mostPoints, add)}
        {button("trash", text.removePoint, all > 2, remove)}
      </p>
      <NumberControl
        label={text.axisValue}
        unit={unit}
        value={value}
        limits={limits}
        slide={slide}
        rest={rest}
        change={(to, held) => move(point, to, opacity, held)}
      />
      <NumberControl
        label={text.opacity}
        unit={t.settings.percent}
        value={100 * opacity}
        limits={{ low: 0, high: 100 }}
        step={0.5}
        rest={rest}
        change={(to, held) => move(point, value, to / 100, held)}
      />
    </div>
  );
}
