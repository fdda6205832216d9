import { expect, test } from "vitest";
import { secondsLeft, withMark, type Mark } from "./pace";

const after = (...told: readonly (readonly [number, number])[]): readonly Mark[] =>
  told.reduce<readonly Mark[]>((marks, [atMs, done]) => withMark(marks, { atMs, done }), []);

test("the estimate is the remaining time at an even pace", () => {
  expect(secondsLeft(after([0, 0], [2000, 20], [4000, 40]), 100)).toBeCloseTo(6);
});

test("there is no estimate too early or while nothing is sent", () => {
  expect(secondsLeft(after([0, 0], [2000, 20]), 100)).toBeNull();
  expect(secondsLeft(after([0, 20], [9000, 20]), 100)).toBeNull();
  expect(secondsLeft([], 100)).toBeNull();
});

test("the estimate ignores old measurements, and starts again after a lost part", () => {
  const slowThenQuick = after([0, 0], [60_000, 10], [62_000, 30], [64_000, 50]);
  expect(secondsLeft(slowThenQuick, 100)).toBeCloseTo(5);
  expect(after([0, 0], [5000, 50], [6000, 40])).toEqual([{ atMs: 6000, done: 40 }]);
});
