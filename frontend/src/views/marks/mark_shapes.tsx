import type { Area, Point } from "../../input/flat";
import type { Mark } from "../../marks/mark";
import { keyOf, type Marks } from "../../marks/marks";
import { shapesOf, type Shapes } from "../../marks/shapes";
import type { MarkView } from "../../marks/view";

export interface MarkShapesProps {
  readonly marks: Marks;
  /** The number of this viewer in the session, by which the worker names the hidden marks. */
  readonly number: number;
  readonly view: MarkView;
  readonly area: Area;
}

/** All marks of all participants in a picture or a slice. */
export function MarkShapes({ marks, number, view, area }: MarkShapesProps) {
  const own = marks.shown.value ? marks.items.value.map((mark) => ({ number, mark })) : [];
  return (
    <g class="marks">
      {[...marks.othersList.value, ...own].map(({ number: whose, mark }) => (
        <MarkShape
          key={keyOf(whose, mark.id)}
          name={keyOf(whose, mark.id)}
          mark={mark}
          view={view}
          area={area}
          chosen={whose === number && marks.editing.value && marks.selected.value === mark.id}
        />
      ))}
    </g>
  );
}

interface MarkShapeProps extends Pick<MarkShapesProps, "view" | "area"> {
  readonly name: string;
  readonly mark: Mark;
  readonly chosen: boolean;
}

function MarkShape({ name, mark, view, area, chosen }: MarkShapeProps) {
  const look = view.lookOf(mark, name);
  const shapes = look === "none" ? null : shapesOf(mark, view, area);
  if (!shapes) return null;
  return (
    <g
      class={chosen ? "mark-shape mark-chosen" : "mark-shape"}
      data-mark={name}
      data-kind={mark.kind}
      data-colour={mark.colour}
      data-look={look}
    >
      <Lines shapes={shapes} layer="mark-under" />
      <Lines shapes={shapes} layer="mark-over" />
      {shapes.text?.said ? (
        <text x={shapes.text.at.x} y={shapes.text.at.y} text-anchor={shapes.text.anchor}>
          {shapes.text.said}
        </text>
      ) : null}
    </g>
  );
}

const corners = (points: readonly Point[]): string => points.map(({ x, y }) => `${x},${y}`).join(" ");

/**
 * Draws the lines of a mark in one of two layers. The lower one is dark and wide, so that they can
 * be seen on any picture.
 */
function Lines({ shapes, layer }: { readonly shapes: Shapes; readonly layer: "mark-under" | "mark-over" }) {
  const { lines, head, circle, dots } = shapes;
  return (
    <g class={layer}>
      {lines.map(([from, to], i) => (
        <line key={i} x1={from.x} y1={from.y} x2={to.x} y2={to.y} />
      ))}
      {head.length > 0 ? <polygon points={corners(head)} /> : null}
      {circle ? <circle cx={circle.at.x} cy={circle.at.y} r={circle.radius} /> : null}
      {dots.map(({ x, y }, i) => (
        <circle key={i} class="mark-dot" cx={x} cy={y} r={3.5} />
      ))}
    </g>
  );
}
