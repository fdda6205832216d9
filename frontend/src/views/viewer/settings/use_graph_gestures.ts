import type { RefObject } from "preact";
import { useRef } from "preact/hooks";
import type { Channel } from "../../../protocol/gen/api/proto/scene_pb";
import { graphHeight, graphWidth, nearestPoint, opacityOf, pointsOf, valueAt, type At } from "./curve";
import { applyGraphKey, graphKeyAction, type GraphActs } from "./graph_keys";

/** Maximum distance from a point at which a finger grabs it, in the units of the graph. */
const reach = 16;

/** The gestures and keys that choose, move, add and remove points of the active channel. */
export function useGraphGestures(active: Channel | undefined, leads: boolean, acts: GraphActs) {
  const svg = useRef<SVGSVGElement>(null);
  const held = useRef<number | null>(null);
  const points = active ? pointsOf(active, acts.range) : [];
  const placed = ({ x, y }: At) => ({
    value: Math.round(valueAt(x, acts.range)),
    opacity: Number(opacityOf(y).toFixed(3)),
  });
  return {
    svg,
    grab: (event: PointerEvent) => {
      const near = leads && event.button === 0 ? nearestPoint(points, placeInGraph(svg, event), reach) : null;
      if (near === null) return;
      held.current = near;
      acts.choose(near);
      svg.current?.setPointerCapture(event.pointerId);
    },
    drag: (event: PointerEvent) => {
      if (held.current === null) return;
      const { value, opacity } = placed(placeInGraph(svg, event));
      acts.move(held.current, value, opacity, true);
    },
    drop: () => {
      if (held.current !== null) acts.rest();
      held.current = null;
    },
    /** A double click away from all points adds one. */
    doubleClick: (event: MouseEvent) => {
      const at = placeInGraph(svg, event);
      if (leads && nearestPoint(points, at, reach / 2) === null) acts.add(placed(at));
    },
    key: (event: KeyboardEvent) => {
      const chosen = active?.opacity[acts.point];
      const action = leads && chosen ? graphKeyAction(event, acts.range.high - acts.range.low) : null;
      if (!action || !chosen) return;
      event.preventDefault();
      applyGraphKey(action, chosen, points.length, acts);
    },
  };
}

function placeInGraph(svg: RefObject<SVGSVGElement | null>, event: MouseEvent): At {
  const box = svg.current?.getBoundingClientRect() ?? new DOMRect();
  return {
    x: ((event.clientX - box.x) / Math.max(1, box.width)) * graphWidth,
    y: ((event.clientY - box.y) / Math.max(1, box.height)) * graphHeight,
  };
}
