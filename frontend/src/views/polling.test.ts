import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { startPolling } from "./polling";

/** The ends of the rounds that have begun. Each is given the time until the next one. */
let ends: ((waitMs: number) => void)[] = [];
const round = () => new Promise<number>((resolve) => ends.push(resolve));

async function endLast(waitMs: number): Promise<void> {
  ends.at(-1)?.(waitMs);
  await vi.advanceTimersByTimeAsync(0);
}

beforeEach(() => {
  ends = [];
  vi.useFakeTimers();
});
afterEach(() => void vi.useRealTimers());

it("begins a round after the time that the last one told", async () => {
  startPolling(round);
  await endLast(100);
  await vi.advanceTimersByTimeAsync(99);
  expect(ends).toHaveLength(1);
  await vi.advanceTimersByTimeAsync(1);
  expect(ends).toHaveLength(2);
});

it("runs one round at a time, however often another one is asked for", async () => {
  const polling = startPolling(round);
  polling.now();
  polling.now();
  expect(ends).toHaveLength(1);
  await endLast(1000);
  expect(ends).toHaveLength(2);
  await endLast(1000);
  expect(ends).toHaveLength(2);
  polling.now();
  polling.now();
  expect(ends).toHaveLength(3);
  await endLast(1000);
  await endLast(1000);
  await vi.advanceTimersByTimeAsync(1000);
  expect(ends).toHaveLength(5);
});

it("begins no round once it was stopped", async () => {
  const polling = startPolling(round);
  polling.stop();
  await endLast(0);
  polling.now();
  await vi.advanceTimersByTimeAsync(1000);
  expect(ends).toHaveLength(1);
});
