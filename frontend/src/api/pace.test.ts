import { expect, test } from "vitest";
import { seconds_left, with_mark, type Mark } from "./pace";

const after = (...told: readonly (readonly [number, number])[]): readonly Mark[] =>
  told.reduce<readonly Mark[]>((marks, [at_ms, done]) => with_mark(marks, { at_ms, done }), []);

test("an even pace gives the time that is left", () => {
  expect(seconds_left(after([0, 0], [2000, 20], [4000, 40]), 100)).toBeCloseTo(6);
});

test("nothing is said too early, nor when nothing moves", () => {
  expect(seconds_left(after([0, 0], [2000, 20]), 100)).toBeNull();
  expect(seconds_left(after([0, 20], [9000, 20]), 100)).toBeNull();
  expect(seconds_left([], 100)).toBeNull();
});

test("what was long ago does not count, and a lost part begins anew", () => {
  const slow_then_quick = after([0, 0], [60_000, 10], [62_000, 30], [64_000, 50]);
  expect(seconds_left(slow_then_quick, 100)).toBeCloseTo(5);
  expect(after([0, 0], [5000, 50], [6000, 40])).toEqual([{ at_ms: 6000, done: 40 }]);
});
