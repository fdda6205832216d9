import { describe, expect, it } from "vitest";
import { effort_from, effort_text, full_effort, stop_of, stopping } from "./effort";

describe("what is kept of the effort", () => {
  it("comes back as it was", () => {
    const effort = { smooth: false, stop_error: 0.05, stop_samples: 0, moving_scale: 0.5 };
    expect(effort_from(effort_text(effort))).toEqual(effort);
  });

  it("is all of it where nothing, junk, or what cannot be was kept", () => {
    for (const text of [null, "", "junk", "null", "7", "[]", '{"stop_error":"0.1","stop_samples":-3,"moving_scale":0.4}', '{"stop_error":null}'])
      expect(effort_from(text)).toEqual(full_effort);
    expect(effort_from('{"stop_error":9e9,"stop_samples":2.4}')).toEqual({ ...full_effort, stop_error: 1, stop_samples: 2 });
  });
});

it("stops by one thing or the other", () => {
  expect(stop_of(full_effort)).toBe("best");
  const by_error = stopping(full_effort, "error");
  expect(stop_of(by_error)).toBe("error");
  const by_samples = stopping(by_error, "samples");
  expect([stop_of(by_samples), by_samples.stop_error]).toEqual(["samples", 0]);
  expect(stopping(by_samples, "best")).toEqual(full_effort);
});
