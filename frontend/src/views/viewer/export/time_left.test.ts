import { expect, test } from "vitest";
import { secondsLeft, withProgress, type ProgressMark } from "./time_left";

const after = (...steps: readonly (readonly [number | null, number])[]) =>
  steps.reduce<readonly ProgressMark[]>((marks, [done, atMs]) => withProgress(marks, done, atMs), []);

test("the time left follows from the pictures that are done", () => {
  expect(secondsLeft(after())).toBeNull();
  expect(secondsLeft(after([null, 1000]))).toBeNull();
  expect(secondsLeft(after([null, 1000], [0.25, 11_000]))).toBeCloseTo(30);
  expect(secondsLeft(after([null, 1000], [0.25, 11_000], [0.25, 20_000]))).toBeCloseTo(30); // said twice
  expect(secondsLeft(after([null, 1000], [0.5, 11_000], [1, 31_000]))).toBe(0);
  expect(secondsLeft(after([null, 0], [0.1, 60_000], [0.2, 70_000]))).toBeCloseTo(80); // the first one waited
});

test("the time left starts again with another worker", () => {
  expect(secondsLeft(after([null, 0], [0.5, 1000], [null, 5000]))).toBeNull();
  expect(secondsLeft(after([null, 0], [0.5, 1000], [null, 5000], [0.1, 7000]))).toBeCloseTo(18);
  expect(secondsLeft(after([null, 0], [0.5, 1000], [0.1, 5000], [0.2, 7000]))).toBeCloseTo(16);
});

test("the time left follows a server that becomes slower", () => {
  const marks = after([null, 0], ...Array.from({ length: 50 }, (_, i) => [(i + 1) / 100, 1000 * (i + 1)] as const));
  expect(secondsLeft(marks)).toBeCloseTo(50);
  const slower = Array.from({ length: 19 }, (_, i) => [(51 + i) / 100, 50_000 + 10_000 * (i + 1)] as const);
  const left = secondsLeft(slower.reduce((all, [done, at]) => withProgress(all, done, at), marks));
  expect(left).toBeCloseTo(310);
});
