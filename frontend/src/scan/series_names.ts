import type { Series } from "./types";

/**
 * A name for each series, by its key. Series with the same description are told apart by their numbers, and phases of
 * one series by their order.
 */
export function seriesNames(
  series: readonly Pick<Series, "key" | "description" | "fileName" | "seriesNumber">[],
  untitled: string,
): ReadonlyMap<string, string> {
  const nameOf = ({ description, fileName }: Pick<Series, "description" | "fileName">) =>
    description.trim() || fileName || untitled;
  const names = new Map<string, string>();
  for (const one of series) {
    const sameName = series.filter((other) => nameOf(other) === nameOf(one));
    const numbers = new Set(sameName.map(({ seriesNumber }) => seriesNumber));
    const numbered = numbers.size === sameName.length && one.seriesNumber !== null;
    const mark = sameName.length === 1 ? "" : numbered ? ` (${one.seriesNumber})` : ` (${sameName.indexOf(one) + 1})`;
    names.set(one.key, nameOf(one) + mark);
  }
  return names;
}
