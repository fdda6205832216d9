import type { Area } from "../../../input/flat";
import type { Slices } from "../../../slices/model";
import { pointOf } from "../../../slices/placing";
import { spotOf, type Stack } from "../../../slices/stack";
import type { Vec3 } from "../../../input/vec3";

export interface CurveLineProps {
  readonly slices: Slices;
  readonly stack: Stack;
  /** The shown slice. */
  readonly index: number;
  readonly area: Area;
}

/** The curve over a slice. Parts and points outside of the slice are faint. */
export function CurveLine({ slices, stack, index, area }: CurveLineProps) {
  const { curve } = slices;
  const points = curve.points.value;
  if (points.length === 0 || slices.following.value || slices.access.value === "shown") return null;
  const placing = slices.placing(stack);
  const half = Math.max(0.5, slices.slab.value.mm / 2 / Math.hypot(stack.next.x, stack.next.y, stack.next.z));
  const projected = (place: Vec3) => {
    const spot = spotOf(stack, place);
    return { ...pointOf(stack, placing, area, spot), near: Math.abs(spot.slice - index) <= half + 1e-3 };
  };
  const line = (curve.path.value?.places ?? points).map(projected);
  const near = line.slice(1).flatMap((to, i) => {
    const from = line[i];
    return from?.near && to.near ? [`M${from.x} ${from.y}L${to.x} ${to.y}`] : [];
  });
  return (
    <svg class="slice-marks slice-curve" aria-hidden="true" width={area.width} height={area.height}>
      <polyline class="slice-curve-far" points={line.map(({ x, y }) => `${x},${y}`).join(" ")} />
      <path d={near.join("")} />
      {points.map(projected).map(({ x, y, near: here }, i) => (
        <circle
          key={i}
          class={here ? (curve.held.value === i ? "slice-held" : undefined) : "slice-curve-far"}
          cx={x}
          cy={y}
          r={4}
        />
      ))}
    </svg>
  );
}
