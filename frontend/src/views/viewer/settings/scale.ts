import { clamp, type Limits } from "../../../scene/numbers";

/**
 * Number of steps of a slider, about one per pixel. They map to values with even differences or
 * even factors.
 */
export const sliderSteps = 1000;

/** Returns the slider step of a value. If `logarithmic`, `low` must be above 0. */
export function toSlider(value: number, { low, high }: Limits, logarithmic: boolean): number {
  const part = logarithmic ? Math.log(Math.max(value, low) / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(sliderSteps * clamp(Number.isFinite(part) ? part : 0, 0, 1));
}

/** Returns the value of a slider step, rounded to as many digits as the slider can resolve. */
export function fromSlider(at: number, { low, high }: Limits, logarithmic: boolean, step: number): number {
  const part = clamp(at / sliderSteps, 0, 1);
  if (part === 0) return low;
  if (part === 1) return high;
  if (logarithmic) return clamp(Number((low * (high / low) ** part).toPrecision(3)), low, high);
  // Rounds twice: to a step, and then to remove the error of adding decimal steps.
  return clamp(Number((Math.round((low + part * (high - low)) / step) * step).toPrecision(12)), low, high);
}
