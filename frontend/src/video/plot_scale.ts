import type { ErrorPoint } from "./picture_facts";

/** A log-log plot of error against time, in whole decades of error. */
export interface Plot {
  /** The curve as `x,y x,y …` in a box of `width` by `height`. */
  readonly line: string;
  /** The error that falls with the square root of time and ends where the curve does, clipped to the box. */
  readonly guide: string;
  readonly vertical: readonly { readonly at: number; readonly seconds: number }[];
  readonly horizontal: readonly { readonly at: number; readonly percent: number }[];
  /** The places at which the curve has 1, 10, 100 … samples per pixel. */
  readonly samples: readonly { readonly at: number; readonly samples: number }[];
}

/** The smallest ratio of samples from point to point, as in renderd/film/error_curve.h. */
const step = 1.05;

const isKnown = ({ seconds, error }: Pick<ErrorPoint, "seconds" | "error">) =>
  seconds > 0 && error > 0 && Number.isFinite(seconds + error);

/**
 * Adds the state after one more pass. Between the first and the last point, samples rise by at least 5% from point to
 * point. The time of a picture includes its own tone mapping, so it may be slightly less than that of the previous
 * picture. The plot's time does not go back.
 */
export function withPoint(curve: readonly ErrorPoint[], point: ErrorPoint): readonly ErrorPoint[] {
  const last = curve.at(-1);
  if (!isKnown(point) || (last && point.samples <= last.samples)) return curve;
  const { samples, seconds, error } = point;
  const before = curve.at(-2);
  const kept = before && samples < step * before.samples ? curve.slice(0, -1) : curve;
  return [...kept, { samples, seconds: Math.max(seconds, kept.at(-1)?.seconds ?? 0), error }];
}

const decades = (from: number, to: number): number[] =>
  Array.from({ length: Math.max(0, Math.floor(to) - Math.ceil(from) + 1) }, (_, i) => Math.ceil(from) + i);
const power = (exponent: number): number => Number((10 ** exponent).toPrecision(1));

export function plotOf(points: readonly ErrorPoint[], width: number, height: number): Plot | null {
  const usable = points.filter(isKnown);
  if (usable.length < 2) return null;
  const xs = usable.map(({ seconds }) => Math.log10(seconds));
  const ys = usable.map(({ error }) => Math.log10(error));
  const left = Math.min(...xs);
  const right = Math.max(...xs, left + 1);
  const top = Math.ceil(Math.max(...ys) - 1e-9);
  const bottom = Math.min(Math.floor(Math.min(...ys) + 1e-9), top - 1);
  const xOf = (x: number) => ((x - left) / (right - left)) * width;
  const yOf = (y: number) => ((top - y) / (top - bottom)) * height;
  const pair = (x: number, y: number) => `${xOf(x).toFixed(1)},${yOf(y).toFixed(1)}`;
  const endX = xs.at(-1) ?? left,
    endY = ys.at(-1) ?? bottom;
  const guideX = Math.max(left, endX - 2 * (top - endY));
  return {
    line: xs.map((x, i) => pair(x, ys[i] ?? bottom)).join(" "),
    guide: `${pair(guideX, endY + (endX - guideX) / 2)} ${pair(endX, endY)}`,
    vertical: decades(left, right).map((x) => ({ at: xOf(x), seconds: power(x) })),
    horizontal: decades(bottom, top).map((y) => ({ at: yOf(y), percent: power(y + 2) })),
    samples: sampleMarks(usable).map(({ x, samples }) => ({ at: xOf(x), samples })),
  };
}

/** Interpolates where the curve reaches each power of ten of samples. */
function sampleMarks(points: readonly ErrorPoint[]): { readonly x: number; readonly samples: number }[] {
  const logs = points.map(({ samples, seconds }) => ({ n: Math.log10(samples), x: Math.log10(seconds) }));
  const first = logs[0],
    last = logs.at(-1);
  if (!first || !last) return [];
  return decades(first.n, last.n).flatMap((n) => {
    const after = logs.findIndex((one) => one.n >= n - 1e-9);
    const b = logs[after],
      a = logs[after - 1] ?? b;
    if (!a || !b) return [];
    const share = b.n > a.n ? (n - a.n) / (b.n - a.n) : 1;
    return [{ x: a.x + share * (b.x - a.x), samples: power(n) }];
  });
}
