import type { Area, Point } from "../../../input/flat";
import { is_whole, measured, type Measure } from "../../../slices/measure";
import { point_of, type Placing } from "../../../slices/placing";
import { spot_of, type Stack } from "../../../slices/stack";
import type { Vec3 } from "../../../input/vec3";
import { t } from "../../../texts";

export interface MarksProps {
  readonly stack: Stack;
  readonly placing: Placing;
  readonly area: Area;
  readonly crosshair: Vec3;
  readonly measures: readonly Measure[];
}

/** Of the crosshair, around its middle: what lies there is to be seen. */
const gap = 9;

/** The crosshair, and what was measured in this slice. */
export function Marks({ stack, placing, area, crosshair, measures }: MarksProps) {
  const on_view = (place: Vec3): Point => point_of(stack, placing, area, spot_of(stack, place));
  const { x, y } = on_view(crosshair);
  return (
    <svg class="slice-marks" aria-hidden="true" width={area.width} height={area.height}>
      <path class="slice-cross" d={`M0 ${y}H${Math.max(0, x - gap)}M${x + gap} ${y}H${area.width}M${x} 0V${Math.max(0, y - gap)}M${x} ${y + gap}V${area.height}`} />
      {measures.map((measure, i) => <MeasureMark key={i} measure={measure} points={measure.points.map(on_view)} area={area} />)}
    </svg>
  );
}

function MeasureMark({ measure, points, area }: { readonly measure: Measure; readonly points: readonly Point[]; readonly area: Area }) {
  const value = measured(measure);
  const at = (measure.kind === "angle" ? points[1] : points.at(-1)) ?? { x: 0, y: 0 };
  const right = at.x > area.width - 90;
  return (
    <g class={is_whole(measure) ? "slice-measure" : "slice-measure slice-measure-open"}>
      <polyline points={points.map((point) => `${point.x},${point.y}`).join(" ")} />
      {points.map((point, i) => <circle key={i} cx={point.x} cy={point.y} r={3.5} />)}
      {value === null ? null : (
        <text x={at.x + (right ? -9 : 9)} y={Math.max(16, at.y - 9)} text-anchor={right ? "end" : "start"}>{t.slices[measure.kind](value)}</text>
      )}
    </g>
  );
}
