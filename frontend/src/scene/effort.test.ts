import { describe, expect, it } from "vitest";
import { effortFrom, effortText, fullEffort, stopOf, stopping } from "./effort";

describe("the stored effort", () => {
  it("is restored", () => {
    const effort = { smooth: false, stop_error: 0.05, stop_samples: 0, moving_scale: 0.5 };
    expect(effortFrom(effortText(effort))).toEqual(effort);
  });

  it("is the full effort if nothing, damaged text or an invalid value was stored", () => {
    for (const text of [
      null,
      "",
      "junk",
      "null",
      "7",
      "[]",
      '{"stop_error":"0.1","stop_samples":-3,"moving_scale":0.4}',
      '{"stop_error":null}',
    ])
      expect(effortFrom(text)).toEqual(fullEffort);
    expect(effortFrom('{"stop_error":9e9,"stop_samples":2.4}')).toEqual({
      ...fullEffort,
      stop_error: 1,
      stop_samples: 2,
    });
  });
});

it("stops at an error or at a number of samples", () => {
  expect(stopOf(fullEffort)).toBe("best");
  const byError = stopping(fullEffort, "error");
  expect(stopOf(byError)).toBe("error");
  const bySamples = stopping(byError, "samples");
  expect([stopOf(bySamples), bySamples.stop_error]).toEqual(["samples", 0]);
  expect(stopping(bySamples, "best")).toEqual(fullEffort);
});
