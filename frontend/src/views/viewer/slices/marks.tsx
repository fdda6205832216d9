import { useMemo } from "preact/hooks";
import type { Area, Point } from "../../../input/flat";
import { handlesOf, isWhole, type Held, type Measure } from "../../../slices/measure";
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
}

/** The free area around the middle of the crosshair, so that the content there stays visible. */
const gap = 9;

/** The crosshair and the measurements in this slice. */
export function Marks({ slice, placing, area, crosshair, measures, index, held }: MarksProps) {
  const { stack } = slice;
  const onView = (place: Vec3): Point => pointOf(stack, placing, area, spotOf(stack, place));
  const { x, y } = onView(crosshair);
  return (
    <svg class="slice-marks" aria-hidden="true" width={area.width} height={area.height}>
      <path
        class="slice-cross"
        d={`M0 ${y}H${Math.max(0, x - gap)}M${x + gap} ${y}H${area.width}M${x} 0V${Math.max(0, y - gap)}M${x} ${y + gap}V${area.height}`}
      />
      {measures.map((measure, i) =>
        isInSlice(measure, stack, index) ? (
          <MeasureMark
            key={i}
            slice={slice}
            measure={measure}
            onView={onView}
            area={area}
            held={held?.measure === i ? held.handle : null}
          />
        ) : null,
      )}
    </svg>
  );
}

export const isInSlice = (measure: Measure, stack: Stack, index: number): boolean =>
  measure.plane === stack.plane && measure.slice === index;

interface MeasureMarkProps {
  readonly slice: MeasuredSlice;
  readonly measure: Measure;
  readonly onView: (place: Vec3) => Point;
  readonly area: Area;
  /** The handle that is being moved. */
  readonly held: number | null;
}

function MeasureMark({ slice, measure, onView, area, held }: MeasureMarkProps) {
  const { stack, pixels, hounsfield } = slice;
  // The crosshair moves more often than these change, and a large ellipse has a hundred thousand pixels.
  const lines = useMemo(
    () => measureLines(measure, { stack, pixels, hounsfield }),
    [measure, stack, pixels, hounsfield],
  );
  const points = handlesOf(stack, measure).map(onView);
  const isEllipse = measure.kind === "ellipse" && isWhole(measure);
  return (
    <g class={isWhole(measure) ? "slice-measure" : "slice-measure slice-measure-open"}>
      {isEllipse ? (
        <EllipseOutline points={points} />
      ) : (
        <polyline points={points.map((point) => `${point.x},${point.y}`).join(" ")} />
      )}
      {points.map((point, i) => (
        <circle key={i} class={i === held ? "slice-held" : undefined} cx={point.x} cy={point.y} r={3.5} />
      ))}
      {isEllipse ? (
        <Lines lines={lines} {...besideEllipse(points, area, lines.length)} />
      ) : (
        <Lines lines={lines} {...besidePoint(measure.kind === "angle" ? points[1] : points.at(-1), area)} />
      )}
    </g>
  );
}

/** `points` are the handles of the ellipse. */
function EllipseOutline({ points }: { readonly points: readonly Point[] }) {
  const [left, right, top, bottom, centre] = points;
  if (!left || !right || !top || !bottom || !centre) return null;
  return (
    <ellipse cx={centre.x} cy={centre.y} rx={Math.abs(right.x - left.x) / 2} ry={Math.abs(bottom.y - top.y) / 2} />
  );
}

interface Beside {
  readonly x: number;
  readonly y: number;
  readonly anchor: "start" | "middle" | "end";
}

function besidePoint(point: Point | undefined, area: Area): Beside {
  const at = point ?? { x: 0, y: 0 };
  const right = at.x > area.width - 90;
  return { x: at.x + (right ? -9 : 9), y: Math.max(16, at.y - 9), anchor: right ? "end" : "start" };
}

const lineHeight = 16;
/** The width of the longest line, for the choice of a side. */
const linesWidth = 175;

/** Returns the first line's place: on the right of the ellipse, else on its left, else above or below it. */
function besideEllipse(points: readonly Point[], area: Area, count: number): Beside {
  const xs = points.map(({ x }) => x);
  const ys = points.map(({ y }) => y);
  const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const within = (y: number) => Math.min(Math.max(y, 2 * lineHeight), area.height - count * lineHeight);
  const middle = within((top + bottom) / 2 - ((count - 1) * lineHeight) / 2 + 5);
  if (right + 9 + linesWidth <= area.width) return { x: right + 9, y: middle, anchor: "start" };
  if (left - 9 - linesWidth >= 0) return { x: left - 9, y: middle, anchor: "end" };
  const x = Math.min(Math.max((left + right) / 2, linesWidth / 2), area.width - linesWidth / 2);
  const above = top - count * lineHeight + 6;
  return { x, y: within(above > 2 * lineHeight ? above : bottom + lineHeight + 2), anchor: "middle" };
}

function Lines({ lines, x, y, anchor }: Beside & { readonly lines: readonly string[] }) {
  if (lines.length === 0) return null;
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
