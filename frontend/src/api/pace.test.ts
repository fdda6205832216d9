import { expect, test } from "vitest";
import { secondsLeft, withMark, type Mark } from "./pace";

const after = (...told: readonly (readonly [number, number])[]): readonly Mark[] =>
  told.reduce<readonly Mark[]>((marks, [atMs, done]) => withMark(marks, { atMs, done }), []);

test("an even pace gives the time that is left", () => {
  expect(secondsLeft(after([0, 0], [2000, 20], [4000, 40]), 100)).toBeCloseTo(6);
});

test("nothing is said too early, nor when nothing moves", () => {
  expect(secondsLeft(after([0, 0], [2000, 20]), 100)).toBeNull();
  expect(secondsLeft(after([0, 20], [9000, 20]), 100)).toBeNull();
  expect(secondsLeft([], 100)).toBeNull();
});

test("what was long ago does not count, and a lost part starts again", () => {
  const slowThenQuick = after([0, 0], [60_000, 10], [62_000, 30], [64_000, 50]);
  expect(secondsLeft(slowThenQuick, 100)).toBeCloseTo(5);
  expect(after([0, 0], [5000, 50], [6000, 40])).toEqual([{ atMs: 6000, done: 40 }]);
});
