import type { Channel } from "../../../protocol/gen/api/proto/scene_pb";
import { clamp, type Limits } from "../../../scene/numbers";

/** The size of the graph in its own units. The page scales the graph. */
export const graphWidth = 320;
export const graphHeight = 150;
/** Margin for points at the edges. */
export const graphEdge = 10;

export interface At {
  readonly x: number;
  readonly y: number;
}

export const xOf = (value: number, { low, high }: Limits): number =>
  graphEdge + ((value - low) / (high - low)) * (graphWidth - 2 * graphEdge);
export const yOf = (opacity: number): number => graphHeight - graphEdge - opacity * (graphHeight - 2 * graphEdge);

export const valueAt = (x: number, { low, high }: Limits): number =>
  low + ((x - graphEdge) / (graphWidth - 2 * graphEdge)) * (high - low);
export const opacityOf = (y: number): number =>
  clamp((graphHeight - graphEdge - y) / (graphHeight - 2 * graphEdge), 0, 1);

export const pointsOf = (channel: Channel, range: Limits): At[] =>
  channel.opacity.map((p) => ({ x: xOf(p.value, range), y: yOf(p.opacity) }));

const text = (points: readonly At[]): string => points.map(({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");
export const lineOf = (channel: Channel, range: Limits): string => text(pointsOf(channel, range));

/** Returns the polygon between a channel's curve and the axis. */
export function areaOf(channel: Channel, range: Limits): string {
  const points = pointsOf(channel, range);
  const first = points[0],
    last = points.at(-1);
  return first && last ? text([{ x: first.x, y: yOf(0) }, ...points, { x: last.x, y: yOf(0) }]) : "";
}

/**
 * Returns the point under the pointer, or null. If two are equally near, returns the later one, which is drawn on top.
 */
export function nearestPoint(points: readonly At[], at: At, reach: number): number | null {
  let found: number | null = null,
    least = reach;
  points.forEach((p, i) => {
    const far = Math.hypot(p.x - at.x, p.y - at.y);
    if (far > least) return;
    least = far;
    found = i;
  });
  return found;
}
