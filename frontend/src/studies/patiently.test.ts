import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { ApiProblem } from "../api/client";
import { patiently } from "./patiently";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

function begin(...results: readonly (Error | string)[]) {
  const seen: string[] = [];
  let attempts = 0;
  const stop = patiently(
    () => {
      const result = results[attempts++];
      return result instanceof Error ? Promise.reject(result) : Promise.resolve(result);
    },
    {
      done: (result) => seen.push(`done ${result}`),
      refused: () => seen.push("refused"),
      waiting: () => seen.push("waiting"),
    },
  );
  return { seen, stop };
}

const absent = new TypeError("Failed to fetch");

it("repeats a request until the server answers it", async () => {
  const { seen } = begin(absent, new ApiProblem(503, "busy", ""), "yes");
  await vi.advanceTimersByTimeAsync(10_000);
  expect(seen).toEqual(["waiting", "waiting", "done yes"]);
});

it("does not repeat a request that was refused", async () => {
  const { seen } = begin(new ApiProblem(410, "study-full", ""), "no");
  await vi.advanceTimersByTimeAsync(10_000);
  expect(seen).toEqual(["refused"]);
});

it("reports nothing after the end", async () => {
  const { seen, stop } = begin(absent, "no");
  await vi.advanceTimersByTimeAsync(100);
  stop();
  await vi.advanceTimersByTimeAsync(10_000);
  expect(seen).toEqual(["waiting"]);
});
