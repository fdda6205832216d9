import type { Area, Point } from "../../../input/flat";
import { handlesOf, isInSlice, isWhole, type Held, type Measure } from "../../../slices/measure";
import { labelPlaces, lineHeight, type LabelPlace } from "../../../slices/label_places";
import { traceOf } from "../../../slices/oblique";
import { pointOf, type Placing } from "../../../slices/placing";
import { spotOf, type Stack } from "../../../slices/stack";
import type { Vec3 } from "../../../input/vec3";
import { measureLines, type MeasuredSlice } from "./measure_text";

export interface MarksProps {
  readonly slice: MeasuredSlice;
  readonly placing: Placing;
  readonly area: Area;
  readonly crosshair: Vec3;
  /** All measurements, of which those in this slice are drawn. */
  readonly measures: readonly Measure[];
  readonly index: number;
  readonly held: Held | null;
  /** The stacks of the other planes, whose lines cross this slice. */
  readonly others: readonly Stack[];
  /** Whether the tool turns the planes, so that their lines have handles. */
  readonly turning: boolean;
}

/**
 * Distance from the middle of the crosshair to its lines in pixels, so that the content there stays
 * visible.
 */
const gap = 9;

/** The crosshair and the measurements in this slice. */
export function Marks({ slice, placing, area, crosshair, measures, index, held, others, turning }: MarksProps) {
  const { stack } = slice;
  const onView = (place: Vec3): Point => pointOf(stack, placing, area, spotOf(stack, place));
  const middle = onView(crosshair);
  const shown = measures.flatMap((measure, i) =>
    isInSlice(measure, stack, index)
      ? [{ measure, i, points: handlesOf(stack, measure).map(onView), lines: measureLines(measure, slice) }]
      : [],
  );
  const labels = shown.map(({ measure, points, lines }) => ({ lines, beside: besideOf(measure, points) }));
  const places = labelPlaces(labels, area);
  return (
    <svg class="slice-marks" aria-hidden="true" width={area.width} height={area.height}>
      {others.map((other) => (
        <CrossLine key={other.plane} middle={middle} along={traceOf(stack, other)} area={area} turning={turning} />
      ))}
      {shown.map(({ measure, i, points, lines }, nth) => (
        <g key={i} class={isWhole(measure) ? "slice-measure" : "slice-measure slice-measure-open"}>
          <Outline measure={measure} points={points} />
          {points.map((point, handle) => (
            <circle
              key={handle}
              class={held?.measure === i && held.handle === handle ? "slice-held" : undefined}
              cx={point.x}
              cy={point.y}
              r={3.5}
            />
          ))}
          <Lines lines={lines} place={places[nth]} />
        </g>
      ))}
    </svg>
  );
}

interface CrossLineProps {
  readonly middle: Point;
  /** The direction of the line, of length 1. */
  readonly along: Point;
  readonly area: Area;
  readonly turning: boolean;
}

/** The line in which another plane cuts this slice. */
function CrossLine({ middle: { x, y }, along, area, turning }: CrossLineProps) {
  const far = area.width + area.height;
  const at = (distance: number) => `${x + distance * along.x} ${y + distance * along.y}`;
  const handle = 0.36 * Math.min(area.width, area.height);
  return (
    <g class="slice-cross">
      <path d={`M${at(-far)}L${at(-gap)}M${at(gap)}L${at(far)}`} />
      {turning
        ? [-handle, handle].map((distance) => (
            <circle key={distance} cx={x + distance * along.x} cy={y + distance * along.y} r={6} />
          ))
        : null}
    </g>
  );
}

/**
 * Returns what the label of a measurement stands beside: an ellipse, the vertex of an angle, or the
 * last point.
 */
function besideOf(measure: Measure, points: readonly Point[]): readonly Point[] {
  if (isEllipse(measure)) return points.slice(0, 4);
  const point = (measure.kind === "angle" ? points[1] : undefined) ?? points.at(-1);
  return point ? [point] : [];
}

const isEllipse = (measure: Measure): boolean => measure.kind === "ellipse" && isWhole(measure);

interface OutlineProps {
  readonly measure: Measure;
  readonly points: readonly Point[];
}

function Outline({ measure, points }: OutlineProps) {
  if (isEllipse(measure)) return <EllipseOutline points={points} />;
  return <polyline points={points.map((point) => `${point.x},${point.y}`).join(" ")} />;
}

/** The outline of an ellipse. `points` are its handles. */
function EllipseOutline({ points }: { readonly points: readonly Point[] }) {
  const [left, right, top, bottom, centre] = points;
  if (!left || !right || !top || !bottom || !centre) return null;
  return (
    <ellipse cx={centre.x} cy={centre.y} rx={Math.abs(right.x - left.x) / 2} ry={Math.abs(bottom.y - top.y) / 2} />
  );
}

interface LinesProps {
  readonly lines: readonly string[];
  readonly place: LabelPlace | undefined;
}

function Lines({ lines, place }: LinesProps) {
  if (lines.length === 0 || !place) return null;
  const { x, y, anchor } = place;
  return (
    <text x={x} y={y} text-anchor={anchor}>
      {lines.length === 1
        ? lines[0]
        : lines.map((line, i) => (
            <tspan key={i} x={x} dy={i === 0 ? 0 : lineHeight}>
              {line}
            </tspan>
          ))}
    </text>
  );
}
