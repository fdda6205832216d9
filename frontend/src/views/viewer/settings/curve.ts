import type { Channel } from "../../../protocol/gen/api/proto/scene_pb";
import { clamp, type Limits } from "../../../scene/numbers";

/** The graph's own units; the page scales it. */
export const graph_width = 320;
export const graph_height = 150;
/** Room for the points at the borders. */
export const graph_edge = 10;

export interface At {
  readonly x: number;
  readonly y: number;
}

export const x_of = (value: number, { low, high }: Limits): number => graph_edge + ((value - low) / (high - low)) * (graph_width - 2 * graph_edge);
export const y_of = (opacity: number): number => graph_height - graph_edge - opacity * (graph_height - 2 * graph_edge);

export const value_at = (x: number, { low, high }: Limits): number => low + ((x - graph_edge) / (graph_width - 2 * graph_edge)) * (high - low);
export const opacity_of = (y: number): number => clamp((graph_height - graph_edge - y) / (graph_height - 2 * graph_edge), 0, 1);

export const points_of = (channel: Channel, range: Limits): At[] => channel.opacity.map((p) => ({ x: x_of(p.value, range), y: y_of(p.opacity) }));

const text = (points: readonly At[]): string => points.map(({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");
export const line_of = (channel: Channel, range: Limits): string => text(points_of(channel, range));

/** Down to the ground at both ends: a channel is closed there. */
export function area_of(channel: Channel, range: Limits): string {
  const points = points_of(channel, range);
  const first = points[0], last = points.at(-1);
  return first && last ? text([{ x: first.x, y: y_of(0) }, ...points, { x: last.x, y: y_of(0) }]) : "";
}

/** The point under a finger, or none; of two as near the later one, which is drawn above. */
export function nearest_point(points: readonly At[], at: At, reach: number): number | null {
  let found: number | null = null, least = reach;
  points.forEach((p, i) => {
    const far = Math.hypot(p.x - at.x, p.y - at.y);
    if (far > least) return;
    least = far;
    found = i;
  });
  return found;
}
