import type { Area, Point } from "../../input/flat";
import type { Vec3 } from "../../input/vec3";
import { corners, edges, onScreen, type Box, type Eye } from "../../picture/project";

export interface ViewOf {
  readonly eye: Eye;
  readonly screen: Area;
}

/** A line between two points. Empty if either is behind the eye. */
export function Stroke({
  from,
  to,
  name,
}: {
  readonly from: Point | null | undefined;
  readonly to: Point | null | undefined;
  readonly name: string;
}) {
  return from && to ? <line class={name} x1={from.x} y1={from.y} x2={to.x} y2={to.y} /> : null;
}

/** The edges of a box, over the picture. */
export function BoxLines({ eye, screen, box }: ViewOf & { readonly box: Box }) {
  const at = corners(box).map((corner) => onScreen(eye, screen, corner));
  return (
    <>
      {edges.map(([a, b]) => (
        <Stroke key={`${a}-${b}`} from={at[a]} to={at[b]} name="handle-edge" />
      ))}
    </>
  );
}

/** The polygon in which a plane intersects the box. */
export function PlaneShape({ eye, screen, polygon }: ViewOf & { readonly polygon: readonly Vec3[] }) {
  const points = polygon.flatMap((corner) => {
    const p = onScreen(eye, screen, corner);
    return p ? [`${p.x},${p.y}`] : [];
  });
  return points.length > 2 ? <polygon points={points.join(" ")} /> : null;
}
