import type { Area, Point } from "../../../input/flat";
import { isWhole, measured, type Measure } from "../../../slices/measure";
import { pointOf, type Placing } from "../../../slices/placing";
import { spotOf, type Stack } from "../../../slices/stack";
import type { Vec3 } from "../../../input/vec3";
import { t } from "../../../texts";

export interface MarksProps {
  readonly stack: Stack;
  readonly placing: Placing;
  readonly area: Area;
  readonly crosshair: Vec3;
  readonly measures: readonly Measure[];
}

/** The free area around the middle of the crosshair, so that the content there stays visible. */
const gap = 9;

/** The crosshair and the measurements in this slice. */
export function Marks({ stack, placing, area, crosshair, measures }: MarksProps) {
  const onView = (place: Vec3): Point => pointOf(stack, placing, area, spotOf(stack, place));
  const { x, y } = onView(crosshair);
  return (
    <svg class="slice-marks" aria-hidden="true" width={area.width} height={area.height}>
      <path
        class="slice-cross"
        d={`M0 ${y}H${Math.max(0, x - gap)}M${x + gap} ${y}H${area.width}M${x} 0V${Math.max(0, y - gap)}M${x} ${y + gap}V${area.height}`}
      />
      {measures.map((measure, i) => (
        <MeasureMark key={i} measure={measure} points={measure.points.map(onView)} area={area} />
      ))}
    </svg>
  );
}

function MeasureMark({
  measure,
  points,
  area,
}: {
  readonly measure: Measure;
  readonly points: readonly Point[];
  readonly area: Area;
}) {
  const value = measured(measure);
  const at = (measure.kind === "angle" ? points[1] : points.at(-1)) ?? { x: 0, y: 0 };
  const right = at.x > area.width - 90;
  return (
    <g class={isWhole(measure) ? "slice-measure" : "slice-measure slice-measure-open"}>
      <polyline points={points.map((point) => `${point.x},${point.y}`).join(" ")} />
      {points.map((point, i) => (
        <circle key={i} cx={point.x} cy={point.y} r={3.5} />
      ))}
      {value === null ? null : (
        <text x={at.x + (right ? -9 : 9)} y={Math.max(16, at.y - 9)} text-anchor={right ? "end" : "start"}>
          {t.slices[measure.kind](value)}
        </text>
      )}
    </g>
  );
}
