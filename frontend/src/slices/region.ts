import type { Vec3 } from "../input/vec3";
import type { Measure } from "./measure";
import { blank, pixelSize, placeOf, spotOf, type Stack } from "./stack";

/** Statistics of the pixels whose centre is inside an ellipse. */
export interface Region {
  readonly mean: number;
  /** The standard deviation of these pixels (divided by their number, since they are not a sample of others). */
  readonly deviation: number;
  readonly minimum: number;
  readonly maximum: number;
  readonly pixels: number;
  /** The area of the ellipse in mm². */
  readonly area: number;
}

/** The pixels of a slice that have a value of the scan. */
export interface Measurable {
  readonly values: Int16Array;
  /** Whether a point is inside the volume. An oblique volume leaves corners of its slices empty. */
  readonly isInside: (place: Vec3) => boolean;
  /** Whether the slice is clipped, so that blank pixels have no value. */
  readonly clipped: boolean;
}

interface Ellipse {
  readonly column: number;
  readonly row: number;
  /** Half of the size in pixels. */
  readonly across: number;
  readonly down: number;
}

function ellipseOf(stack: Stack, { points }: Measure): Ellipse | null {
  const [a, b] = points.map((point) => spotOf(stack, point));
  if (!a || !b) return null;
  return {
    column: (a.column + b.column) / 2,
    row: (a.row + b.row) / 2,
    across: Math.abs(b.column - a.column) / 2,
    down: Math.abs(b.row - a.row) / 2,
  };
}

/** Calls `visit` with the column and row of each pixel of the slice whose centre is inside. */
function eachPixel(stack: Stack, ellipse: Ellipse, visit: (column: number, row: number) => void): void {
  const { column, row, across, down } = ellipse;
  if (across === 0 || down === 0) return;
  for (let y = Math.max(0, Math.ceil(row - down)); y <= Math.min(stack.rows - 1, row + down); ++y) {
    const half = across * Math.sqrt(Math.max(0, 1 - ((y - row) / down) ** 2));
    for (let x = Math.max(0, Math.ceil(column - half)); x <= Math.min(stack.columns - 1, column + half); ++x)
      visit(x, y);
  }
}

/** Measures the pixels in an ellipse. Returns null if none with a value has its centre in it. */
export function regionOf(stack: Stack, measure: Measure, { values, isInside, clipped }: Measurable): Region | null {
  const ellipse = ellipseOf(stack, measure);
  if (!ellipse) return null;
  const { column, row, across, down } = ellipse;
  // An ellipse that was made in an oblique slice has no number of a slice.
  const [corner] = measure.points;
  const slice = measure.plane === null && corner ? spotOf(stack, corner).slice : measure.slice;
  const place = (x: number, y: number) => placeOf(stack, { column: x, row: y, slice });
  // The volume is convex, so the pixels need no check if the rectangle around the ellipse is inside.
  const allInside = [-across, across].every((x) => [-down, down].every((y) => isInside(place(column + x, row + y))));
  let pixels = 0;
  let sum = 0;
  let squares = 0;
  let minimum = Infinity;
  let maximum = -Infinity;
  eachPixel(stack, ellipse, (x, y) => {
    const value = values[y * stack.columns + x] ?? blank;
    if ((clipped && value === blank) || (!allInside && !isInside(place(x, y)))) return;
    pixels += 1;
    sum += value;
    squares += value * value;
    minimum = Math.min(minimum, value);
    maximum = Math.max(maximum, value);
  });
  if (pixels === 0) return null;
  const mean = sum / pixels;
  const { width, height } = pixelSize(stack);
  return {
    mean,
    deviation: Math.sqrt(Math.max(0, squares / pixels - mean * mean)),
    minimum,
    maximum,
    pixels,
    area: Math.PI * across * width * down * height,
  };
}
