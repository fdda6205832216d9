import type { Area, Point } from "../input/flat";
import type { Mark } from "./mark";
import { saidOf } from "./said";
import type { MarkView } from "./view";

/** What is drawn for a mark, in pixels. The page draws it as SVG, and a saved picture on a canvas. */
export interface Shapes {
  readonly lines: readonly (readonly [Point, Point])[];
  /** The tip of an arrow as a triangle. */
  readonly head: readonly Point[];
  readonly circle: { readonly at: Point; readonly radius: number } | null;
  /** The point that a text is about, or those of a measurement. */
  readonly dots: readonly Point[];
  readonly text: { readonly at: Point; readonly anchor: "start" | "middle" | "end"; readonly said: string } | null;
}

const shortestArrow = 14;
const leastRadius = 3;
/** The space that a text may need, for the choice of a side. */
const textWidth = 130;

/** Returns the shapes of a mark, or null if it is not in the view. `unit` enlarges lines and texts in large pictures. */
export function shapesOf(mark: Mark, view: MarkView, area: Area, unit = 1): Shapes | null {
  const at = view.pointOf(mark.place);
  if (!at) return null;
  const none: Shapes = { lines: [], head: [], circle: null, dots: [], text: null };
  switch (mark.kind) {
    case "arrow":
      return { ...none, ...arrow(mark, view, at, area, unit) };
    case "circle": {
      const radius = Math.max(leastRadius * unit, view.radiusOf(mark.place, mark.radius));
      const above = at.y - radius - 8 * unit;
      const y = above > 16 * unit ? above : at.y + radius + 18 * unit;
      return { ...none, circle: { at, radius }, text: { at: { x: at.x, y }, anchor: "middle", said: saidOf(mark) } };
    }
    case "text":
      return { ...none, dots: [at], text: { ...beside(at, area, unit), said: saidOf(mark) } };
    case "ruler":
    case "angle":
      return { ...none, ...measurement(mark, view, at, area, unit) };
  }
}

/** A ruler has its value beside its second end, and an angle beside its vertex. A worker draws the same into files. */
function measurement(mark: Mark, view: MarkView, at: Point, area: Area, unit: number): Partial<Shapes> {
  const tail = view.pointOf(mark.tail) ?? at;
  const end = mark.kind === "angle" ? (view.pointOf(mark.end) ?? at) : null;
  return {
    lines: end
      ? [
          [at, tail],
          [at, end],
        ]
      : [[at, tail]],
    dots: end ? [at, tail, end] : [at, tail],
    text: { ...beside(end ? at : tail, area, unit), said: saidOf(mark) },
  };
}

function arrow(mark: Mark, view: MarkView, at: Point, area: Area, unit: number): Partial<Shapes> {
  const tail = view.pointOf(mark.tail) ?? at;
  const size = Math.hypot(tail.x - at.x, tail.y - at.y);
  // An arrow that points straight away from the viewer would have no direction.
  const [x, y] = size > 1 ? [(tail.x - at.x) / size, (tail.y - at.y) / size] : [-0.7, -0.7];
  const longest = Math.max(size, shortestArrow * unit);
  const end = { x: at.x + x * longest, y: at.y + y * longest };
  const along = (ahead: number, side: number): Point => ({
    x: at.x + unit * (x * ahead - y * side),
    y: at.y + unit * (y * ahead + x * side),
  });
  const right = end.x >= at.x;
  const fits = right ? end.x + textWidth * unit < area.width : end.x > textWidth * unit;
  const anchor = right === fits ? "start" : "end";
  return {
    lines: [[end, along(8, 0)]],
    head: [at, along(13, 5.5), along(13, -5.5)],
    text: {
      at: { x: end.x + (anchor === "start" ? 6 : -6) * unit, y: end.y + (fits ? 4 : -8) * unit },
      anchor,
      said: saidOf(mark),
    },
  };
}

function beside(at: Point, area: Area, unit: number): { readonly at: Point; readonly anchor: "start" | "end" } {
  const right = at.x + textWidth * unit < area.width;
  return { at: { x: at.x + (right ? 10 : -10) * unit, y: at.y + 5 * unit }, anchor: right ? "start" : "end" };
}
