import type { Me } from "./types";

/** What of the month's picture time is left, as the viewer says it. Plain data; no clock, no network. */
export type PictureTime =
  | { readonly kind: "enough" }
  /** So many minutes of a renderer's work, or less. */
  | { readonly kind: "soon"; readonly minutes: number }
  /** All is used: the picture that is open ends then, also when it is at rest. */
  | { readonly kind: "ending"; readonly at_ms: number };

const minute_ms = 60_000;
/** Said when no more than this is left. */
const said_at_ms = [5 * minute_ms, minute_ms];

export function picture_time(time: Me["render_time"]): PictureTime {
  if (time.pictures_end_at !== null) return { kind: "ending", at_ms: Date.parse(time.pictures_end_at) };
  const left_ms = time.quota_ms - time.used_ms;
  const soon = said_at_ms.some((at) => left_ms <= at);
  return soon ? { kind: "soon", minutes: Math.max(1, Math.ceil(left_ms / minute_ms)) } : { kind: "enough" };
}

/** After how long to ask the server again: a few open pictures use their time side by side, so soon enough for all of them. */
export function asked_again_ms(time: Me["render_time"]): number {
  const left_ms = time.quota_ms - time.used_ms;
  const next_ms = said_at_ms.find((at) => at < left_ms) ?? 0;
  return Math.min(Math.max((left_ms - next_ms) / 3, 5000), 2 * minute_ms);
}
