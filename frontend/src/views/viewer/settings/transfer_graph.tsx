import { noFlick } from "../../../input/no_flick";
import type { Channel, TransferFunction } from "../../../protocol/gen/api/proto/scene_pb";
import type { Histogram } from "../../../protocol/messages";
import { hexOf } from "../../../scene/colour";
import { outline } from "../../../scene/histogram";
import type { Limits } from "../../../scene/numbers";
import { t } from "../../../texts";
import { numberText } from "../../format";
import { areaOf, graphEdge, graphHeight, graphWidth, lineOf, pointsOf } from "./curve";
import type { GraphActs } from "./graph_keys";
import { useGraphGestures } from "./use_graph_gestures";

export interface TransferGraphProps extends GraphActs {
  readonly transfer: TransferFunction;
  readonly histogram: Histogram | null;
  readonly logarithmic: boolean;
  readonly channel: number;
  readonly leads: boolean;
}

/** All channels over the histogram. Mouse, touch and keys can move the points of the active channel. */
export function TransferGraph(props: TransferGraphProps) {
  const { transfer, range, channel, point, leads } = props;
  const active = transfer.channels[channel];
  const points = active ? pointsOf(active, range) : [];
  const gestures = useGraphGestures(active, leads, props);
  return (
    <>
      <svg
        ref={gestures.svg}
        class="graph"
        viewBox={`0 0 ${graphWidth} ${graphHeight}`}
        role="application"
        aria-label={t.settings.look.graph}
        aria-describedby="graph-help graph-point"
        tabindex={0}
        onTouchMove={noFlick}
        onPointerDown={gestures.grab}
        onPointerMove={gestures.drag}
        onPointerUp={gestures.drop}
        onPointerCancel={gestures.drop}
        onDblClick={gestures.doubleClick}
        onKeyDown={gestures.key}
        data-points={points.length}
      >
        <HistogramArea histogram={props.histogram} range={range} logarithmic={props.logarithmic} />
        <ChannelCurves channels={transfer.channels} active={channel} range={range} />
        {points.map(({ x, y }, i) => (
          <circle
            key={i}
            class={i === point ? "graph-point graph-point-chosen" : "graph-point"}
            cx={x}
            cy={y}
            r={i === point ? 6.5 : 5}
          />
        ))}
      </svg>
      <p class="visually-hidden" id="graph-point" role="status">
        {pointText(active, point)}
      </p>
    </>
  );
}

type HistogramAreaProps = Pick<TransferGraphProps, "histogram" | "range" | "logarithmic">;

function HistogramArea({ histogram, range, logarithmic }: HistogramAreaProps) {
  if (!histogram || histogram.counts.length === 0) return null;
  return (
    <g transform={`translate(${graphEdge} ${graphEdge})`}>
      <polygon
        class="graph-histogram"
        points={outline(histogram, range, graphWidth - 2 * graphEdge, graphHeight - 2 * graphEdge, logarithmic)}
      />
    </g>
  );
}

interface ChannelCurvesProps {
  readonly channels: readonly Channel[];
  readonly active: number;
  readonly range: Limits;
}

/** The curves of all shown channels. The active one is drawn on top. */
function ChannelCurves({ channels, active, range }: ChannelCurvesProps) {
  const over = channels[active];
  return (
    <>
      {channels.map((one, i) =>
        one.disabled ? null : (
          <g key={i}>
            <polygon class="graph-area" points={areaOf(one, range)} fill={hexOf(one.diffuse)} />
            <polyline
              class={i === active ? "graph-line graph-line-active" : "graph-line"}
              points={lineOf(one, range)}
              stroke={hexOf(one.diffuse)}
            />
          </g>
        ),
      )}
      {over ? <polyline class="graph-line-over" points={lineOf(over, range)} /> : null}
    </>
  );
}

/** Returns the chosen point in words, for a screen reader. */
function pointText(channel: Channel | undefined, point: number): string {
  const chosen = channel?.opacity[point];
  if (!chosen) return "";
  const opacity = numberText(100 * chosen.opacity, 3);
  return t.settings.look.pointSaid(point + 1, channel.opacity.length, numberText(chosen.value, 6), opacity);
}
