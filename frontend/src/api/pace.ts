/** How fast something goes on, and how long it will still take: from what was told within the last seconds. */

export interface Mark {
  readonly at_ms: number;
  readonly done: number;
}

const looked_back_ms = 15_000;
const least_ms = 3_000;

/** The marks to keep once `mark` is told. Going back (a part that was lost is sent again) begins anew. */
export function with_mark(marks: readonly Mark[], mark: Mark): readonly Mark[] {
  const last = marks.at(-1);
  if (last && mark.done < last.done) return [mark];
  return [...marks.filter((one) => one.at_ms >= mark.at_ms - looked_back_ms), mark];
}

/** Nothing while it is too early to say, or when nothing moves. */
export function seconds_left(marks: readonly Mark[], total: number): number | null {
  const first = marks[0];
  const last = marks.at(-1);
  if (!first || !last || last.at_ms - first.at_ms < least_ms || last.done <= first.done) return null;
  return ((total - last.done) * (last.at_ms - first.at_ms)) / (last.done - first.done) / 1000;
}
