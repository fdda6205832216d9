import type { Area, Point } from "../input/flat";
import { add, length, scale, type Vec3 } from "../input/vec3";
import { beside, frameOf, onScreen, type Eye } from "../picture/project";
import { perMm, pixelAt, pointOf, type Placing } from "../slices/placing";
import { inSlice, placeOf, spotOf, type Stack } from "../slices/stack";
import type { Rectangle } from "../video/picture_in";
import { measuringPoints, pointsOf, type Mark } from "./mark";

/** How a mark appears: as it is, faint because it lies behind matter or beside the slice, or not at all. */
export type Look = "plain" | "faint" | "none";

/** A picture or a slice on which marks are drawn and made. Points are in pixels. */
export interface MarkView {
  /** Returns where a place appears, or null if it is behind the eye. */
  readonly pointOf: (place: Vec3) => Point | null;
  /** Returns the place at the same depth that appears `by` pixels away. */
  readonly beside: (place: Vec3, by: Point) => Vec3;
  /** Returns the radius in pixels at which a sphere appears. */
  readonly radiusOf: (place: Vec3, radius: number) => number;
  readonly lookOf: (mark: Mark, key: string) => Look;
}

/**
 * Returns the view of a rendered picture. `picture` is where it is drawn, and `hidden` has the keys
 * of the marks behind matter.
 */
export function viewOfPicture(eye: Eye, picture: Rectangle, hidden: ReadonlySet<string>): MarkView {
  const at = (place: Vec3): Point | null => {
    const point = onScreen(eye, picture, place);
    return point && { x: picture.x + point.x, y: picture.y + point.y };
  };
  return {
    pointOf: at,
    beside: (place, by) => beside(eye, picture, place, by),
    radiusOf: (place, radius) => {
      const edge = at(add(place, scale(frameOf(eye).right, radius)));
      const middle = at(place);
      return edge && middle ? Math.hypot(edge.x - middle.x, edge.y - middle.y) : 0;
    },
    lookOf: (_, key) => (hidden.has(key) ? "faint" : "plain"),
  };
}

/** Marks this close to a slice appear in it, but faint. */
export const nearMm = 5;

export function viewOfSlice(stack: Stack, placing: Placing, area: Area, index: number): MarkView {
  const thickness = length(stack.next);
  const away = (place: Vec3) => Math.max(0, Math.abs(spotOf(stack, place).slice - index) - 0.5) * thickness;
  const pixels = perMm(stack, placing, area);
  return {
    pointOf: (place) => pointOf(stack, placing, area, spotOf(stack, place)),
    beside: (place, by) => {
      const right = scale(stack.right, by.x / pixels / length(stack.right));
      return add(place, add(right, scale(stack.down, by.y / pixels / length(stack.down))));
    },
    radiusOf: (place, radius) => {
      const off = away(place);
      return off < radius ? pixels * Math.sqrt(radius * radius - off * off) : pixels * radius;
    },
    lookOf: (mark) => {
      const { kind, place, radius } = mark;
      const off = kind in measuringPoints ? Math.max(...pointsOf(mark).map(away)) : away(place);
      if (off === 0 || (kind === "circle" && off < radius)) return "plain";
      const near = kind in measuringPoints ? Math.min(...pointsOf(mark).map(away)) : off;
      return near <= nearMm ? "faint" : "none";
    },
  };
}

/** Returns the place in a slice at a point of its view. */
export const placeInSlice = (stack: Stack, placing: Placing, area: Area, index: number, at: Point): Vec3 =>
  inSlice(stack, placeOf(stack, { ...pixelAt(stack, placing, area, at), slice: index }), index);
