import type { FileOrder } from "../../../protocol/file_messages";
import type { Scene, Viewport } from "../../../protocol/messages";
import { longest_film_s, longest_film_side } from "../../../video/file_shot";
import { with_longest_side } from "./shot_size";

export const film_sides = { small: 640, medium: 1280, large: longest_film_side } as const;
export const film_rates = [10, 25, 30, 60] as const;
export const most_key_views = 16;

/** Of the shape of the screen; a film's sides are even. */
export function film_size(screen: Viewport, longest: number): Viewport {
  const { width, height } = with_longest_side(screen, longest);
  const even = (side: number) => Math.max(16, Math.round(side / 2) * 2);
  return { width: even(width), height: even(height) };
}

/** Whole seconds as they were typed; nothing where they are out of bounds. */
export function typed_seconds(text: string): number | null {
  const seconds = /^\d{1,3}$/.test(text.trim()) ? Number(text) : 0;
  return seconds >= 1 && seconds <= longest_film_s ? seconds : null;
}

export interface FilmChoices {
  readonly kind: "turntable" | "tour";
  readonly keys: readonly Scene[];
  readonly size: Viewport;
  readonly seconds: number;
  readonly rate: number;
  readonly error: number;
}

export const film_order = ({ kind, keys, size, seconds, rate, error }: FilmChoices): FileOrder => ({
  kind,
  keys,
  size,
  frames: seconds * rate,
  frames_per_second: rate,
  error,
});
