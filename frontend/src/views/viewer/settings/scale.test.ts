import { describe, expect, it } from "vitest";
import { fromSlider, sliderSteps, toSlider } from "./scale";

describe("a slider", () => {
  const ways = [
    { limits: { low: -120.5, high: 300.25 }, log: false, step: 0.1 },
    { limits: { low: 0.001, high: 100 }, log: true, step: 0.001 },
    { limits: { low: 0, high: 1 }, log: false, step: 0.01 },
  ];
  it("reaches both of its ends exactly and never leaves them", () => {
    for (const { limits, log, step } of ways) {
      expect(fromSlider(0, limits, log, step)).toBe(limits.low);
      expect(fromSlider(sliderSteps, limits, log, step)).toBe(limits.high);
      for (let at = -5; at <= sliderSteps + 5; at++) {
        const value = fromSlider(at, limits, log, step);
        expect(value >= limits.low && value <= limits.high).toBe(true);
      }
    }
  });
  it("rises monotonically, and is at the position of its value", () => {
    for (const { limits, log, step } of ways)
      for (let at = 10; at < sliderSteps; at += 10) {
        const value = fromSlider(at, limits, log, step);
        expect(value).toBeGreaterThanOrEqual(fromSlider(at - 10, limits, log, step));
        expect(Math.abs(toSlider(value, limits, log) - at)).toBeLessThanOrEqual(5);
      }
  });
  it("stops at an end for a value beyond it or an invalid one", () => {
    expect(toSlider(-5, { low: 0, high: 1 }, false)).toBe(0);
    expect(toSlider(0, { low: 0.1, high: 10 }, true)).toBe(0);
    expect(toSlider(1e9, { low: 0.1, high: 10 }, true)).toBe(sliderSteps);
    expect(toSlider(3, { low: 3, high: 3 }, false)).toBe(0);
  });
});
