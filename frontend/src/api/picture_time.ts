import type { Me } from "./types";

/** The rendering time left this month, as the viewer shows it. Plain data without clock or network. */
export type PictureTime =
  | { readonly kind: "enough" }
  /** At most this many minutes of rendering time are left. */
  | { readonly kind: "soon"; readonly minutes: number }
  /** No time is left. Open pictures end at this time, even if they are finished. */
  | { readonly kind: "ending"; readonly atMs: number };

const minuteMs = 60_000;
/** The remaining times at which the user is warned. */
const saidAtMs = [5 * minuteMs, minuteMs];

export function pictureTime(time: Me["render_time"]): PictureTime {
  if (time.pictures_end_at !== null) return { kind: "ending", atMs: Date.parse(time.pictures_end_at) };
  const leftMs = time.quota_ms - time.used_ms;
  const soon = saidAtMs.some((at) => leftMs <= at);
  return soon ? { kind: "soon", minutes: Math.max(1, Math.ceil(leftMs / minuteMs)) } : { kind: "enough" };
}

/**
 * Returns the delay before the next request to the server: a third of the time left until the next
 * warning, because several open pictures may use it up in parallel.
 */
export function pollDelayMs(time: Me["render_time"]): number {
  const leftMs = time.quota_ms - time.used_ms;
  const nextMs = saidAtMs.find((at) => at < leftMs) ?? 0;
  return Math.min(Math.max((leftMs - nextMs) / 3, 5000), 2 * minuteMs);
}
