import type { Annotations } from "../protocol/mark_messages";

/**
 * Returns the content of an item without its ID and set, because two windows may give different
 * marks the same ID.
 */
const keyOf = (item: object): string => JSON.stringify({ ...item, id: undefined, set: undefined });

/**
 * Adds to `theirs` the items that are new in `mine`, and removes those that `mine` no longer has.
 * Items are compared with `base`.
 */
function mergedItems<Item extends object>(
  base: readonly Item[],
  mine: readonly Item[],
  theirs: readonly Item[],
): readonly Item[] {
  const known = new Set(base.map(keyOf));
  const kept = new Set(mine.map(keyOf));
  const there = new Set(theirs.map(keyOf));
  const isRemoved = (key: string) => known.has(key) && !kept.has(key);
  const isNew = (key: string) => !known.has(key) && !there.has(key);
  return [...theirs.filter((item) => !isRemoved(keyOf(item))), ...mine.filter((item) => isNew(keyOf(item)))];
}

/** Merges two changes of the same marks and measurements. What both windows changed is kept in both forms. */
export const merged = (base: Annotations, mine: Annotations, theirs: Annotations): Annotations => ({
  marks: mergedItems(base.marks, mine.marks, theirs.marks),
  measures: mergedItems(base.measures, mine.measures, theirs.measures),
});
