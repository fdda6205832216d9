/** The progress of a file at a time. */
export interface ProgressMark {
  /** The completed fraction, from 0 to 1. */
  readonly done: number;
  readonly atMs: number;
}

/**
 * Number of marks to keep: few enough to show a change of speed soon, but more than a single slow
 * picture affects.
 */
const mostMarks = 20;

/** Adds the progress of a file. Null, or less than before, means that the work starts again. */
export function withProgress(
  marks: readonly ProgressMark[],
  done: number | null,
  atMs: number,
): readonly ProgressMark[] {
  const last = marks.at(-1);
  if (done === null || !last || done < last.done) return [{ done: done ?? 0, atMs }];
  return done === last.done ? marks : [...marks, { done, atMs }].slice(-mostMarks);
}

/** Returns the seconds that the rest takes at the speed so far, or null while nothing is done. */
export function secondsLeft(marks: readonly ProgressMark[]): number | null {
  // The first picture also waits until the one on the screen needs less of the device.
  const counted = marks.length > 2 && marks[0]?.done === 0 ? marks.slice(1) : marks;
  const [first, last] = [counted[0], counted.at(-1)];
  if (!first || !last || last.done <= first.done) return null;
  return ((last.atMs - first.atMs) / 1000 / (last.done - first.done)) * (1 - last.done);
}
