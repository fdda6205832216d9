import type { Series } from "./types";

type Numbered = Pick<Series, "key" | "seriesNumber">;

/**
 * Returns what distinguishes series of the same name, by their keys: their numbers, or for phases
 * of one series their order. Empty for a name that occurs once.
 */
export function marksOfNames<One extends Numbered>(
  series: readonly One[],
  nameOf: (one: One) => string,
): ReadonlyMap<string, string> {
  const marks = new Map<string, string>();
  for (const one of series) {
    const sameName = series.filter((other) => nameOf(other) === nameOf(one));
    const numbers = new Set(sameName.map(({ seriesNumber }) => seriesNumber));
    const numbered = numbers.size === sameName.length && one.seriesNumber !== null;
    const mark = numbered ? ` (${one.seriesNumber})` : ` (${sameName.indexOf(one) + 1})`;
    marks.set(one.key, sameName.length === 1 ? "" : mark);
  }
  return marks;
}

/** Returns a name for each series, by its key. No two are the same. */
export function seriesNames(
  series: readonly Pick<Series, "key" | "description" | "fileName" | "seriesNumber">[],
  untitled: string,
): ReadonlyMap<string, string> {
  const nameOf = ({ description, fileName }: Pick<Series, "description" | "fileName">) =>
    description.trim() || fileName || untitled;
  const marks = marksOfNames(series, nameOf);
  return new Map(series.map((one) => [one.key, nameOf(one) + (marks.get(one.key) ?? "")]));
}
