import type { Me } from "./types";

/** What of the month's picture time is left, as the viewer says it. Plain data; no clock, no network. */
export type PictureTime =
  | { readonly kind: "enough" }
  /** So many minutes of a renderer's work, or less. */
  | { readonly kind: "soon"; readonly minutes: number }
  /** All is used: the picture that is open ends then, also when it is at rest. */
  | { readonly kind: "ending"; readonly atMs: number };

const minuteMs = 60_000;
/** Said when no more than this is left. */
const saidAtMs = [5 * minuteMs, minuteMs];

export function pictureTime(time: Me["render_time"]): PictureTime {
  if (time.pictures_end_at !== null) return { kind: "ending", atMs: Date.parse(time.pictures_end_at) };
  const leftMs = time.quota_ms - time.used_ms;
  const soon = saidAtMs.some((at) => leftMs <= at);
  return soon ? { kind: "soon", minutes: Math.max(1, Math.ceil(leftMs / minuteMs)) } : { kind: "enough" };
}

/** After how long to ask the server again: a few open pictures use their time side by side, so soon enough for all of them. */
export function askedAgainMs(time: Me["render_time"]): number {
  const leftMs = time.quota_ms - time.used_ms;
  const nextMs = saidAtMs.find((at) => at < leftMs) ?? 0;
  return Math.min(Math.max((leftMs - nextMs) / 3, 5000), 2 * minuteMs);
}
