import type { Limits } from "./numbers";

/** How often values occur: `counts[i]` belongs to the bin that starts at `minimum` + i * `width`. */
export interface Histogram {
  readonly minimum: number;
  readonly width: number;
  readonly counts: readonly number[];
}

/**
 * Returns heights from 0 to 1. The linear scale ignores the highest bin, which is the air around the patient and would
 * dwarf all others.
 */
export function heights(counts: readonly number[], logarithmic: boolean): number[] {
  if (logarithmic) {
    const most = Math.log1p(Math.max(0, ...counts));
    return counts.map((n) => (most > 0 ? Math.log1p(n) / most : 0));
  }
  const measure = [...counts].sort((a, b) => b - a)[1] ?? 0;
  return counts.map((n) => (measure > 0 ? Math.min(1, n / measure) : n > 0 ? 1 : 0));
}

/** Returns the points of the histogram's polygon in a box of `width` x `height`, over the values in `range`. */
export function outline(
  histogram: Histogram,
  range: Limits,
  width: number,
  height: number,
  logarithmic: boolean,
): string {
  const x = (value: number) => ((value - range.low) / (range.high - range.low)) * width;
  const points = heights(histogram.counts, logarithmic).flatMap((h, i) => {
    const y = (height * (1 - h)).toFixed(1);
    const from = histogram.minimum + i * histogram.width;
    return [`${x(from).toFixed(1)},${y}`, `${x(from + histogram.width).toFixed(1)},${y}`];
  });
  const end = histogram.minimum + histogram.counts.length * histogram.width;
  return [`${x(histogram.minimum).toFixed(1)},${height}`, ...points, `${x(end).toFixed(1)},${height}`].join(" ");
}
