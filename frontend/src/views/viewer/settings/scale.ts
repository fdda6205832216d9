import { clamp, type Limits } from "../../../scene/numbers";

/** A slider's way: as many steps as there are pixels to feel, over even values or over even factors. */
export const sliderSteps = 1000;

/** Logarithmic: `low` must be above 0. */
export function toSlider(value: number, { low, high }: Limits, logarithmic: boolean): number {
  const part = logarithmic ? Math.log(Math.max(value, low) / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(sliderSteps * clamp(Number.isFinite(part) ? part : 0, 0, 1));
}

/** To as many digits as the way is fine: a hand means no more. */
export function fromSlider(at: number, { low, high }: Limits, logarithmic: boolean, step: number): number {
  const part = clamp(at / sliderSteps, 0, 1);
  if (part === 0) return low;
  if (part === 1) return high;
  if (logarithmic) return clamp(Number((low * (high / low) ** part).toPrecision(3)), low, high);
  // Rounded twice: the step first, then what a sum of decimal steps leaves behind.
  return clamp(Number((Math.round((low + part * (high - low)) / step) * step).toPrecision(12)), low, high);
}
