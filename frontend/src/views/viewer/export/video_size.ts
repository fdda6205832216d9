import type { PresetInfo } from "../../../api/types";
import type { FileOrder } from "../../../protocol/file_messages";
import type { Scene, Viewport } from "../../../protocol/messages";
import type { PictureFacts } from "../../../video/picture_facts";
import { longestVideoS, longestVideoSide } from "../../../video/file_shot";
import { withLongestSide } from "./shot_size";

export const videoSides = { small: 640, medium: 1280, large: longestVideoSide } as const;
export type VideoSide = keyof typeof videoSides;
export const videoSideNames = ["small", "medium", "large"] as const satisfies readonly VideoSide[];
/** The estimated relative error at which a frame of the video is finished. */
export const videoErrors = { quick: 0.05, good: 0.02 } as const;
export type VideoQuality = keyof typeof videoErrors;
export const videoQualities = ["quick", "good"] as const satisfies readonly VideoQuality[];
export const videoRates = [10, 25, 30, 60] as const;
export const mostKeyViews = 16;

/** A view that a tour can visit: a saved preset, or the current view. */
export interface KeyView {
  readonly preset: PresetInfo | null;
  readonly taken: boolean;
}

/** Returns a video size with the shape of the screen. The sides are even, because video codecs need that. */
export function videoSize(screen: Viewport, longest: number): Viewport {
  const { width, height } = withLongestSide(screen, longest);
  const even = (side: number) => Math.max(16, Math.round(side / 2) * 2);
  return { width: even(width), height: even(height) };
}

/** Parses whole seconds. Returns null if they are out of bounds. */
export function typedSeconds(text: string): number | null {
  const seconds = /^\d{1,3}$/.test(text.trim()) ? Number(text) : 0;
  return seconds >= 1 && seconds <= longestVideoS ? seconds : null;
}

/** The share of the device that a video gets while no picture moves (renderd/schedule/still_scheduling.h). */
const videoShare = 0.5;

/**
 * Estimates how long a video takes from how fast the picture on the screen became sharp. The variance of a pixel falls
 * in inverse proportion to its samples. Returns null while the error of the picture is unknown.
 */
export function renderingSeconds(
  shown: Pick<PictureFacts, "samples" | "seconds" | "error" | "width" | "height">,
  frames: number,
  size: Viewport,
  error: number,
): number | null {
  if (!Number.isFinite(shown.error) || shown.samples < 1 || shown.seconds <= 0) return null;
  const samples = Math.max(1, shown.samples * (shown.error / error) ** 2);
  const secondsPerSample = shown.seconds / (shown.samples * shown.width * shown.height);
  return (frames * samples * size.width * size.height * secondsPerSample) / videoShare;
}

export interface VideoChoices {
  readonly kind: "turntable" | "tour";
  readonly keys: readonly Scene[];
  readonly size: Viewport;
  readonly seconds: number;
  readonly rate: number;
  readonly error: number;
}

export const videoOrder = ({ kind, keys, size, seconds, rate, error }: VideoChoices): FileOrder => ({
  kind,
  keys,
  size,
  frames: seconds * rate,
  framesPerSecond: rate,
  error,
});
