import { describe, expect, it } from "vitest";
import "../../texts/testing";
import { fullEffort } from "../../scene/effort";
import { qualityState } from "./quality_state";

const stopAfter = (samples: number) => ({ ...fullEffort, stop_samples: samples });

describe("the state of a picture", () => {
  it("is the progress, also while the picture is denoised", () => {
    const early = { error: 0.2, samples: 80, smoothed: true };
    expect(qualityState(early, stopAfter(100), false)).toEqual({
      finished: false,
      text: "Sharpening… 80%",
      part: 0.8,
    });
  });

  it("has no percentage until the noise is measured, and none once the picture is finished", () => {
    expect(qualityState({ error: Infinity, samples: 1 }, fullEffort, false).text).toBe("Sharpening…");
    expect(qualityState({ error: 0.001, samples: 100 }, stopAfter(100), true)).toEqual({
      finished: true,
      text: "Finished",
      part: null,
    });
  });
});
