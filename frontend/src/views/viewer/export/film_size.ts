import type { PresetInfo } from "../../../api/types";
import type { FileOrder } from "../../../protocol/file_messages";
import type { Scene, Viewport } from "../../../protocol/messages";
import { longestFilmS, longestFilmSide } from "../../../video/file_shot";
import { withLongestSide } from "./shot_size";

export const filmSides = { small: 640, medium: 1280, large: longestFilmSide } as const;
export type FilmSide = keyof typeof filmSides;
export const filmSideNames = ["small", "medium", "large"] as const satisfies readonly FilmSide[];
/** The estimated relative error at which a frame of the film is finished. */
export const filmErrors = { quick: 0.05, good: 0.02 } as const;
export type FilmQuality = keyof typeof filmErrors;
export const filmQualities = ["quick", "good"] as const satisfies readonly FilmQuality[];
export const filmRates = [10, 25, 30, 60] as const;
export const mostKeyViews = 16;

/** A view that a tour can visit: a saved preset, or the current view. */
export interface KeyView {
  readonly preset: PresetInfo | null;
  readonly taken: boolean;
}

/** Returns a film size with the shape of the screen. The sides are even, because video codecs need that. */
export function filmSize(screen: Viewport, longest: number): Viewport {
  const { width, height } = withLongestSide(screen, longest);
  const even = (side: number) => Math.max(16, Math.round(side / 2) * 2);
  return { width: even(width), height: even(height) };
}

/** Parses whole seconds. Returns null if they are out of bounds. */
export function typedSeconds(text: string): number | null {
  const seconds = /^\d{1,3}$/.test(text.trim()) ? Number(text) : 0;
  return seconds >= 1 && seconds <= longestFilmS ? seconds : null;
}

export interface FilmChoices {
  readonly kind: "turntable" | "tour";
  readonly keys: readonly Scene[];
  readonly size: Viewport;
  readonly seconds: number;
  readonly rate: number;
  readonly error: number;
}

export const filmOrder = ({ kind, keys, size, seconds, rate, error }: FilmChoices): FileOrder => ({
  kind,
  keys,
  size,
  frames: seconds * rate,
  framesPerSecond: rate,
  error,
});
