import { describe, expect, it } from "vitest";
import { fullEffort } from "../../scene/effort";
import { refinementProgress } from "./part_of_way";

describe("the progress of a picture", () => {
  it("is the fraction of the samples that the renderer needs", () => {
    expect(refinementProgress({ error: 0.02, samples: 10 }, fullEffort)).toBeCloseTo(0.25);
  });
  it("uses the user's own target if there is one", () => {
    expect(refinementProgress({ error: 0.1, samples: 10 }, { ...fullEffort, stop_error: 0.05 })).toBeCloseTo(0.25);
    expect(refinementProgress({ error: 0.5, samples: 64 }, { ...fullEffort, stop_samples: 256 })).toBeCloseTo(0.25);
  });
  it("is unknown while the error is", () => {
    expect(refinementProgress({ error: Infinity, samples: 1 }, fullEffort)).toBeNull();
  });
  it("never reads 100% before the picture is finished", () => {
    expect(refinementProgress({ error: 0.005, samples: 9000 }, fullEffort)).toBe(0.99);
  });
});
