import { seconds_left, with_mark, type Mark } from "./pace";
import type { Hindrance, UploadEnd } from "./upload";

/** Where an upload stands, as the page shows it. Plain data and what becomes of it; no clock, no network. */

/**
 * waiting: others go first; sending; paused: by the person; hindered: nothing gets through, the next try comes by itself;
 * elsewhere: another window of this browser sends it; sent: all of it, and the list of scans does not know yet; refused: for good.
 */
export type UploadPhase = "waiting" | "sending" | "paused" | "hindered" | "elsewhere" | "sent" | "refused";

/** Why the server wants no more of it. */
export type UploadRefusal = "expired" | "gone" | "too_large" | "signed_out" | "other";

export interface UploadView {
  readonly data_set_id: string;
  readonly phase: UploadPhase;
  /** Bytes. */
  readonly sent: number;
  readonly total: number;
  readonly hindrance: Hindrance;
  readonly refusal: UploadRefusal;
  readonly marks: readonly Mark[];
}

export function begun(data_set_id: string, total: number): UploadView {
  return { data_set_id, phase: "waiting", sent: 0, total, hindrance: "connection", refusal: "other", marks: [] };
}

/** A hindrance is over when more arrives than before it, not when a try begins. */
export function with_progress(view: UploadView, sent: number, at_ms: number): UploadView {
  if (view.phase !== "sending" && view.phase !== "hindered") return view;
  const still = view.phase === "hindered" && sent <= view.sent;
  return { ...view, sent, phase: still ? "hindered" : "sending", marks: still ? [] : with_mark(view.marks, { at_ms, done: sent }) };
}

export function in_phase(view: UploadView, phase: UploadPhase): UploadView {
  return { ...view, phase, marks: [] };
}

export function hindered(view: UploadView, by: Hindrance): UploadView {
  return view.phase === "paused" ? view : { ...in_phase(view, "hindered"), hindrance: by };
}

export function refused(view: UploadView, end: UploadEnd & { readonly kind: "refused" }): UploadView {
  const known: Readonly<Record<number, UploadRefusal>> = { 401: "signed_out", 404: "gone", 410: "expired", 413: "too_large" };
  return { ...in_phase(view, "refused"), refusal: known[end.status] ?? "other" };
}

/** Seconds, or nothing while it is too early to say. */
export const time_left = (view: UploadView): number | null => (view.phase === "sending" ? seconds_left(view.marks, view.total) : null);

/** Whether closing the window would cut it. */
export const is_open = (view: UploadView): boolean => ["waiting", "sending", "paused", "hindered"].includes(view.phase);

/** Which of those that wait may begin, when so many may send at once: in the order in which they came. */
export function next_to_send(views: Iterable<UploadView>, at_once: number): string | null {
  const all = [...views];
  const busy = all.filter((view) => view.phase === "sending" || view.phase === "hindered").length;
  return busy < at_once ? (all.find((view) => view.phase === "waiting")?.data_set_id ?? null) : null;
}
