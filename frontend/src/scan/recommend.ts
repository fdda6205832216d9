import type { Series, Suitable } from "./types";

/** The series that gives the best 3D picture, and why. */
export interface Recommendation {
  readonly key: string;
  readonly why: { readonly kind: "thinnest"; readonly mm: number } | { readonly kind: "largest"; readonly mm: number };
}

/** A series that covers less than this share of the longest one shows only a detail. */
const leastCover = 0.5;

const thickness = ({ size, sizeMm }: Suitable): number => Math.round((10 * sizeMm[2]) / size[2]) / 10;
const cover = ({ sizeMm }: Suitable): number => sizeMm[2];

/**
 * Recommends the series with the thinnest slices, because they give a smooth surface, among those
 * that show more than a detail. Returns null if there is no choice.
 */
export function recommend(series: readonly Series[]): Recommendation | null {
  const all = series.flatMap(({ key, verdict }) => (verdict.suitable ? [{ key, verdict }] : []));
  if (all.length < 2) return null;
  const longest = Math.max(...all.map(({ verdict }) => cover(verdict)));
  const [best, second] = all
    .filter(({ verdict }) => cover(verdict) >= leastCover * longest)
    .sort((a, b) => thickness(a.verdict) - thickness(b.verdict) || cover(b.verdict) - cover(a.verdict));
  if (!best) return null;
  const tie = second && thickness(second.verdict) === thickness(best.verdict);
  return {
    key: best.key,
    why: tie
      ? { kind: "largest", mm: Math.round(cover(best.verdict)) }
      : { kind: "thinnest", mm: thickness(best.verdict) },
  };
}
