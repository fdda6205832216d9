import { clamp, type Limits } from "./numbers";

/**
 * How much work the worker puts into a picture. It is not part of the scene, because it does not affect the converged
 * picture.
 */
export interface Effort {
  /** Whether the first pictures of a view are denoised. */
  readonly smooth: boolean;
  /** Relative error at which rendering stops. 0 for the worker's default. */
  readonly stop_error: number;
  /** Samples per pixel at which rendering stops. 0 for the worker's default. */
  readonly stop_samples: number;
  /** Maximum resolution while moving, as a fraction of the full one. */
  readonly moving_scale: number;
}

export const fullEffort: Effort = { smooth: true, stop_error: 0, stop_samples: 0, moving_scale: 1 };

export const stopErrorLimits: Limits = { low: 0.001, high: 1 };
export const stopSamplesLimits: Limits = { low: 1, high: 1_000_000 };
export const movingScales = [1, 0.75, 0.5, 0.25] as const;

export const stops = ["best", "error", "samples"] as const;
export type Stop = (typeof stops)[number];
export const stopOf = ({ stop_error: stopError, stop_samples: stopSamples }: Effort): Stop =>
  stopError > 0 ? "error" : stopSamples > 0 ? "samples" : "best";

/** Applies a stop condition, starting with a value at which a picture looks finished. */
export const stopping = (effort: Effort, stop: Stop): Effort => ({
  ...effort,
  stop_error: stop === "error" ? 0.05 : 0,
  stop_samples: stop === "samples" ? 256 : 0,
});

export const effortText = (effort: Effort): string => JSON.stringify(effort);

/** Parses the stored effort. Returns the full effort if it is damaged. */
export function effortFrom(text: string | null): Effort {
  let value: Partial<Record<keyof Effort, unknown>> | null;
  try {
    value = JSON.parse(text ?? "null") as typeof value;
  } catch {
    return fullEffort;
  }
  if (typeof value !== "object" || value === null) return fullEffort;
  const number = (one: unknown, { low, high }: Limits, otherwise: number) =>
    typeof one === "number" && one > 0 ? clamp(one, low, high) : otherwise;
  return {
    smooth: value.smooth !== false,
    stop_error: number(value.stop_error, stopErrorLimits, 0),
    stop_samples: Math.round(number(value.stop_samples, stopSamplesLimits, 0)),
    moving_scale: movingScales.find((scale) => scale === value.moving_scale) ?? 1,
  };
}
