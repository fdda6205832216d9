import type { PresetInfo } from "../../../api/types";
import type { FileMarks, FileOrder } from "../../../protocol/file_messages";
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

/**
 * The shortest video of "Show me around". It turns once around: by at most 3 degrees per frame at 10 frames per second, as
 * between two pictures on the screen.
 */
export const shortestAroundS = 12;

/** Parses whole seconds. Returns null if they are out of bounds. */
export function typedSeconds(text: string, least = 1): number | null {
  const seconds = /^\d{1,3}$/.test(text.trim()) ? Number(text) : 0;
  return seconds >= least && seconds <= longestVideoS ? seconds : null;
}

/** The shortest and the longest likely duration in seconds. */
export interface TimeRange {
  readonly least: number;
  readonly most: number;
}

/**
 * How much longer a frame takes than the same picture on the screen. The least is for a device that does nothing else. A
 * video gets half of a device while pictures on screens still become sharper or another file is made
 * (renderd/schedule/still_scheduling.h). On a CPU, the encoder and everything else on the machine share the cores.
 */
const slowdown = { gpu: { least: 1, most: 2 }, cpu: { least: 1, most: 3 } } as const;
/** What each frame takes in addition: preparing the scene, denoising and encoding. */
const secondsPerFrame = { gpu: 0.05, cpu: 0.5 } as const;

/**
 * Minimum number of samples for an estimate. With fewer, the error is hardly known or, on a CPU,
 * that of a draft, which another method renders.
 */
const fewestSamples = 4;

/**
 * Estimates how long a video takes from how fast the picture on the screen became sharp. The variance of a pixel falls
 * in inverse proportion to its samples. Returns null while the error of the picture is unknown. `device` is the name of
 * the server's device.
 */
export function renderingSeconds(
  shown: Pick<PictureFacts, "samples" | "seconds" | "error" | "width" | "height">,
  frames: number,
  size: Viewport,
  error: number,
  device: string,
): TimeRange | null {
  if (!Number.isFinite(shown.error) || shown.samples < fewestSamples || shown.seconds <= 0) return null;
  const kind = device.includes("CPU") ? "cpu" : "gpu";
  const samples = Math.max(1, shown.samples * (shown.error / error) ** 2);
  const secondsPerSample = shown.seconds / (shown.samples * shown.width * shown.height);
  const onScreen = samples * size.width * size.height * secondsPerSample;
  const total = (factor: number) => frames * (factor * onScreen + secondsPerFrame[kind]);
  return { least: total(slowdown[kind].least), most: total(slowdown[kind].most) };
}

export interface VideoChoices {
  readonly kind: "turntable" | "tour" | "phases";
  readonly keys: readonly Scene[];
  readonly size: Viewport;
  readonly seconds: number;
  readonly rate: number;
  /** How often all phases of the scan are played. */
  readonly cycles: number;
  readonly error: number;
  readonly marks: FileMarks;
}

export const videoOrder = ({ kind, keys, size, seconds, rate, cycles, error, marks }: VideoChoices): FileOrder => ({
  kind,
  keys,
  size,
  frames: seconds * rate,
  framesPerSecond: rate,
  phaseCycles: cycles,
  error,
  marks,
});

/** Parses how often the phases are played. Returns null if it is out of bounds. */
export function typedCycles(text: string, least: number, frames: number): number | null {
  const cycles = /^\d{1,4}$/.test(text.trim()) ? Number(text) : -1;
  return cycles >= least && cycles <= frames ? cycles : null;
}

const usualVideoSeconds = 4;

/** Returns how often a video of the phases plays `count` phases at first, and how long it takes, in whole seconds. */
export function usualCycles(count: number, perSecond: number): { readonly cycles: number; readonly seconds: number } {
  const cycles = Math.max(1, Math.round((usualVideoSeconds * perSecond) / count));
  return { cycles, seconds: Math.min(longestVideoS, Math.max(1, Math.round((cycles * count) / perSecond))) };
}
