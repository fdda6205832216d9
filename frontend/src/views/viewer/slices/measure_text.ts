import { isWhole, measured, type Measure } from "../../../slices/measure";
import { regionOf, type Measurable } from "../../../slices/region";
import type { Stack } from "../../../slices/stack";
import { t } from "../../../texts";

/** What measurements read: the slice, or null until it has arrived, and whether its values are in Hounsfield units. */
export interface MeasuredSlice {
  readonly stack: Stack;
  readonly pixels: Measurable | null;
  readonly hounsfield: boolean;
}

/**
 * The last lines of each measurement. They are kept, because the crosshair moves more often, and a
 * large ellipse has a hundred thousand pixels.
 */
const read = new WeakMap<Measure, { readonly slice: MeasuredSlice; readonly lines: readonly string[] }>();

/** Returns the lines beside a measurement in the slice. */
export function measureLines(measure: Measure, slice: MeasuredSlice): readonly string[] {
  const known = read.get(measure);
  if (known?.slice === slice) return known.lines;
  const lines = linesOf(measure, slice);
  read.set(measure, { slice, lines });
  return lines;
}

function linesOf(measure: Measure, { stack, pixels, hounsfield }: MeasuredSlice): readonly string[] {
  if (measure.kind !== "ellipse") {
    const value = measured(measure);
    return value === null ? [] : [t.slices[measure.kind](value)];
  }
  if (!isWhole(measure) || !pixels) return [];
  const region = regionOf(stack, measure, pixels);
  if (!region) return [t.slices.ellipseEmpty];
  return [
    t.slices.ellipse(region.mean, region.deviation, hounsfield),
    t.slices.ellipseRange(region.minimum, region.maximum, hounsfield),
    t.slices.ellipseSize(region.area, region.pixels),
  ];
}
