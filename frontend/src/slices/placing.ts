import type { Area, Point } from "../input/flat";
import { length } from "../input/vec3";
import { clamp } from "../scene/numbers";
import { pixelSize, type Grid } from "./stack";

/**
 * How a slice is placed in its view. With `zoom` 1, all of it is visible. The given pixel is in the middle of the view.
 */
export interface Placing {
  readonly zoom: number;
  readonly column: number;
  readonly row: number;
}

export const zoomLimits = { low: 0.5, high: 40 } as const;

export const wholeSlice = (stack: Grid): Placing => ({
  zoom: 1,
  column: (stack.columns - 1) / 2,
  row: (stack.rows - 1) / 2,
});

/** Returns the pixels of the view per mm. A margin stays free for the letters at the edges. */
export function perMm(stack: Grid, placing: Placing, area: Area): number {
  const { width, height } = stack.oblique?.fit ?? sizeOf(stack);
  return 0.94 * placing.zoom * Math.max(1e-6, Math.min(area.width / width, area.height / height));
}

const sizeOf = (stack: Grid) => ({
  width: stack.columns * length(stack.right),
  height: stack.rows * length(stack.down),
});

/** Returns the same place of a slice in a stack with other pixels. Both are centred at the same point. */
export function carried(placing: Placing, from: Grid, to: Grid): Placing {
  const middles = { from: wholeSlice(from), to: wholeSlice(to) };
  const [a, b] = [pixelSize(from), pixelSize(to)];
  return {
    zoom: placing.zoom,
    column: middles.to.column + ((placing.column - middles.from.column) * a.width) / b.width,
    row: middles.to.row + ((placing.row - middles.from.row) * a.height) / b.height,
  };
}

interface Flat {
  readonly column: number;
  readonly row: number;
}

export function pointOf(stack: Grid, placing: Placing, area: Area, { column, row }: Flat): Point {
  const mm = perMm(stack, placing, area);
  const { width, height } = pixelSize(stack);
  return {
    x: area.width / 2 + (column - placing.column) * width * mm,
    y: area.height / 2 + (row - placing.row) * height * mm,
  };
}

export function pixelAt(stack: Grid, placing: Placing, area: Area, { x, y }: Point): Flat {
  const mm = perMm(stack, placing, area);
  const { width, height } = pixelSize(stack);
  return {
    column: placing.column + (x - area.width / 2) / (width * mm),
    row: placing.row + (y - area.height / 2) / (height * mm),
  };
}

const held = (stack: Grid, { zoom, column, row }: Placing): Placing => ({
  zoom,
  column: clamp(column, 0, stack.columns - 1),
  row: clamp(row, 0, stack.rows - 1),
});

/** Zooms and keeps the point under `at` in place. */
export function zoomed(stack: Grid, placing: Placing, area: Area, factor: number, at: Point): Placing {
  const zoom = clamp(placing.zoom * factor, zoomLimits.low, zoomLimits.high);
  const fixed = pixelAt(stack, placing, area, at);
  const moved = pixelAt(stack, { ...placing, zoom }, area, at);
  return held(stack, {
    zoom,
    column: placing.column + fixed.column - moved.column,
    row: placing.row + fixed.row - moved.row,
  });
}

/** Moves the slice with the pointer by a distance in the view. */
export function panned(stack: Grid, placing: Placing, area: Area, right: number, down: number): Placing {
  const from = pixelAt(stack, placing, area, { x: 0, y: 0 });
  const to = pixelAt(stack, placing, area, { x: right, y: down });
  return held(stack, {
    ...placing,
    column: placing.column + from.column - to.column,
    row: placing.row + from.row - to.row,
  });
}
