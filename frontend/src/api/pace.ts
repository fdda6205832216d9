/** How fast something goes on, and how long it will still take: from what was told within the last seconds. */

export interface Mark {
  readonly atMs: number;
  readonly done: number;
}

const lookedBackMs = 15_000;
const leastMs = 3_000;

/** The marks to keep once `mark` is told. Going back (a part that was lost is sent again) begins anew. */
export function withMark(marks: readonly Mark[], mark: Mark): readonly Mark[] {
  const last = marks.at(-1);
  if (last && mark.done < last.done) return [mark];
  return [...marks.filter((one) => one.atMs >= mark.atMs - lookedBackMs), mark];
}

/** Nothing while it is too early to say, or when nothing moves. */
export function secondsLeft(marks: readonly Mark[], total: number): number | null {
  const first = marks[0];
  const last = marks.at(-1);
  if (!first || !last || last.atMs - first.atMs < leastMs || last.done <= first.done) return null;
  return ((total - last.done) * (last.atMs - first.atMs)) / (last.done - first.done) / 1000;
}
