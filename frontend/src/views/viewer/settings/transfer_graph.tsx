import { useRef } from "preact/hooks";
import { no_flick } from "../../../input/no_flick";
import type { TransferFunction } from "../../../protocol/gen/api/proto/scene_pb";
import type { Histogram } from "../../../protocol/messages";
import { hex_of } from "../../../scene/colour";
import { outline } from "../../../scene/histogram";
import { t } from "../../../texts";
import { number_text } from "../../format";
import { area_of, graph_edge, graph_height, graph_width, line_of, nearest_point, opacity_of, points_of, value_at, type At } from "./curve";
import type { PointActs } from "./point_controls";

export interface TransferGraphProps extends PointActs {
  readonly transfer: TransferFunction;
  readonly histogram: Histogram | null;
  readonly logarithmic: boolean;
  readonly channel: number;
  readonly leads: boolean;
  /** Nothing said: where there is most room. */
  readonly add: (at?: { readonly value: number; readonly opacity: number }) => void;
}

/** In the graph's units: a finger's breadth. */
const reach = 16;

/** All channels over the histogram; the points of one of them are in reach of hands and keys. */
export function TransferGraph(props: TransferGraphProps) {
  const { transfer, range, histogram, logarithmic, channel, point, leads } = props;
  const svg = useRef<SVGSVGElement>(null);
  const held = useRef<number | null>(null);
  const active = transfer.channels[channel];
  const points = active ? points_of(active, range) : [];
  const chosen = active?.opacity[point];

  const place = (event: MouseEvent): At => {
    const box = svg.current?.getBoundingClientRect() ?? new DOMRect();
    return { x: ((event.clientX - box.x) / Math.max(1, box.width)) * graph_width, y: ((event.clientY - box.y) / Math.max(1, box.height)) * graph_height };
  };
  const grabbed = (event: PointerEvent) => {
    const near = leads && event.button === 0 ? nearest_point(points, place(event), reach) : null;
    if (near === null) return;
    held.current = near;
    props.choose(near);
    svg.current?.setPointerCapture(event.pointerId);
  };
  const dragged = (event: PointerEvent) => {
    if (held.current === null) return;
    const at = place(event);
    props.move(held.current, Math.round(value_at(at.x, range)), Number(opacity_of(at.y).toFixed(3)), true);
  };
  const dropped = () => {
    if (held.current !== null) props.rest();
    held.current = null;
  };
  const doubled = (event: MouseEvent) => {
    const at = place(event);
    if (leads && nearest_point(points, at, reach / 2) === null) props.add({ value: Math.round(value_at(at.x, range)), opacity: Number(opacity_of(at.y).toFixed(3)) });
  };
  const pressed = (event: KeyboardEvent) => {
    if (!leads || !chosen || event.ctrlKey || event.metaKey || event.altKey) return;
    const action = key_action(event, (range.high - range.low) / (event.shiftKey ? 20 : 200));
    if (!action) return;
    event.preventDefault();
    if (action.kind === "choose") props.choose(Math.min(points.length - 1, Math.max(0, point + action.by)));
    else if (action.kind === "move") props.move(point, chosen.value + action.value, chosen.opacity + action.opacity, false);
    else if (action.kind === "add") props.add();
    else props.remove();
  };
  const said = chosen ? t.settings.look.point_said(point + 1, points.length, number_text(chosen.value, 6), number_text(100 * chosen.opacity, 3)) : "";
  return (
    <>
      <svg ref={svg} class="graph" viewBox={`0 0 ${graph_width} ${graph_height}`} role="application" aria-label={t.settings.look.graph}
        aria-describedby="graph-help graph-point" tabindex={0} onTouchMove={no_flick} onPointerDown={grabbed} onPointerMove={dragged} onPointerUp={dropped}
        onPointerCancel={dropped} onDblClick={doubled} onKeyDown={pressed} data-points={points.length}>
        {histogram && histogram.counts.length > 0 ? (
          <g transform={`translate(${graph_edge} ${graph_edge})`}>
            <polygon class="graph-histogram" points={outline(histogram, range, graph_width - 2 * graph_edge, graph_height - 2 * graph_edge, logarithmic)} />
          </g>
        ) : null}
        {transfer.channels.map((one, i) => one.disabled ? null : (
          <g key={i}>
            <polygon class="graph-area" points={area_of(one, range)} fill={hex_of(one.diffuse)} />
            <polyline class={i === channel ? "graph-line graph-line-active" : "graph-line"} points={line_of(one, range)} stroke={hex_of(one.diffuse)} />
          </g>
        ))}
        {active ? <polyline class="graph-line-over" points={line_of(active, range)} /> : null}
        {points.map(({ x, y }, i) => <circle key={i} class={i === point ? "graph-point graph-point-chosen" : "graph-point"} cx={x} cy={y} r={i === point ? 6.5 : 5} />)}
      </svg>
      <p class="visually-hidden" id="graph-point" role="status">{said}</p>
    </>
  );
}

type Action =
  | { readonly kind: "choose"; readonly by: number }
  | { readonly kind: "move"; readonly value: number; readonly opacity: number }
  | { readonly kind: "add" }
  | { readonly kind: "remove" };

function key_action(event: KeyboardEvent, step: number): Action | null {
  const value = Math.max(1, Math.round(step)), opacity = event.shiftKey ? 0.1 : 0.01;
  switch (event.key) {
    case "PageDown":
      return { kind: "choose", by: 1 };
    case "PageUp":
      return { kind: "choose", by: -1 };
    case "ArrowLeft":
      return { kind: "move", value: -value, opacity: 0 };
    case "ArrowRight":
      return { kind: "move", value, opacity: 0 };
    case "ArrowUp":
      return { kind: "move", value: 0, opacity };
    case "ArrowDown":
      return { kind: "move", value: 0, opacity: -opacity };
    case "Insert":
      return { kind: "add" };
    case "Delete":
      return { kind: "remove" };
    default:
      return null;
  }
}
