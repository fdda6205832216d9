/** Measures the speed of a transfer and estimates its remaining time, both from the marks of the last seconds. */

export interface Mark {
  readonly atMs: number;
  readonly done: number;
}

const lookedBackMs = 15_000;
const leastMs = 3_000;

/**
 * Returns the marks to keep after `mark`. Starts again if the progress goes back, because a lost part is sent again.
 */
export function withMark(marks: readonly Mark[], mark: Mark): readonly Mark[] {
  const last = marks.at(-1);
  if (last && mark.done < last.done) return [mark];
  return [...marks.filter((one) => one.atMs >= mark.atMs - lookedBackMs), mark];
}

/** Estimates the remaining seconds. Returns null if it is too early or nothing moves. */
export function secondsLeft(marks: readonly Mark[], total: number): number | null {
  const first = marks[0];
  const last = marks.at(-1);
  if (!first || !last || last.atMs - first.atMs < leastMs || last.done <= first.done) return null;
  return ((total - last.done) * (last.atMs - first.atMs)) / (last.done - first.done) / 1000;
}
