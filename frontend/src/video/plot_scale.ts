import type { ErrorPoint } from "./picture_facts";

/** A log-log plot of error against time, in whole decades. */
export interface Plot {
  /** The curve as `x,y x,y …` in a box of `width` by `height`. */
  readonly line: string;
  readonly vertical: readonly number[];
  readonly horizontal: readonly { readonly at: number; readonly percent: number }[];
}

const mostPoints = 400;

const isKnown = ({ seconds, error }: ErrorPoint) => seconds > 0 && error > 0 && Number.isFinite(seconds + error);

/**
 * Adds the point of one more picture. Its time includes its own tone mapping, so it may be slightly less than that of
 * the previous picture. The plot's time does not go back.
 */
export function withPoint(curve: readonly ErrorPoint[], { seconds, error }: ErrorPoint): readonly ErrorPoint[] {
  if (!isKnown({ seconds, error })) return curve;
  return [...curve, { seconds: Math.max(seconds, curve.at(-1)?.seconds ?? 0), error }].slice(-mostPoints);
}

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
  const decades = (from: number, to: number) =>
    Array.from({ length: Math.max(0, Math.floor(to) - Math.ceil(from) + 1) }, (_, i) => Math.ceil(from) + i);
  return {
    line: xs.map((x, i) => `${xOf(x).toFixed(1)},${yOf(ys[i] ?? bottom).toFixed(1)}`).join(" "),
    vertical: decades(left, right).map(xOf),
    horizontal: decades(bottom, top).map((y) => ({ at: yOf(y), percent: Number((10 ** (y + 2)).toPrecision(1)) })),
  };
}
