import { secondsLeft, withMark, type Mark } from "./pace";
import type { StallReason, UploadEnd } from "./upload";

/** Where an upload stands, as the page shows it. Plain data and what becomes of it; no clock, no network. */

/**
 * waiting: others go first; sending; paused: by the person; stalled: nothing gets through, the next try comes by itself;
 * elsewhere: another window of this browser sends it; sent: all of it, and the list of scans does not know yet; refused: for good.
 */
export type UploadPhase = "waiting" | "sending" | "paused" | "stalled" | "elsewhere" | "sent" | "refused";

/** Why the server wants no more of it. */
export type UploadRefusal = "expired" | "gone" | "too_large" | "signed_out" | "other";

export interface UploadView {
  readonly data_set_id: string;
  readonly phase: UploadPhase;
  /** Bytes. */
  readonly sent: number;
  readonly total: number;
  readonly stallReason: StallReason;
  readonly refusal: UploadRefusal;
  readonly marks: readonly Mark[];
}

export function begun(dataSetId: string, total: number): UploadView {
  return {
    data_set_id: dataSetId,
    phase: "waiting",
    sent: 0,
    total,
    stallReason: "connection",
    refusal: "other",
    marks: [],
  };
}

/** A stall is over when more bytes arrive than before it, not when a retry begins. */
export function withProgress(view: UploadView, sent: number, atMs: number): UploadView {
  if (view.phase !== "sending" && view.phase !== "stalled") return view;
  const still = view.phase === "stalled" && sent <= view.sent;
  return {
    ...view,
    sent,
    phase: still ? "stalled" : "sending",
    marks: still ? [] : withMark(view.marks, { atMs, done: sent }),
  };
}

export function inPhase(view: UploadView, phase: UploadPhase): UploadView {
  return { ...view, phase, marks: [] };
}

export function stalled(view: UploadView, by: StallReason): UploadView {
  return view.phase === "paused" ? view : { ...inPhase(view, "stalled"), stallReason: by };
}

export function refused(view: UploadView, end: UploadEnd & { readonly kind: "refused" }): UploadView {
  const known: Readonly<Record<number, UploadRefusal>> = {
    401: "signed_out",
    404: "gone",
    410: "expired",
    413: "too_large",
  };
  return { ...inPhase(view, "refused"), refusal: known[end.status] ?? "other" };
}

/** Seconds, or nothing while it is too early to say. */
export const timeLeft = (view: UploadView): number | null =>
  view.phase === "sending" ? secondsLeft(view.marks, view.total) : null;

/** Whether closing the window would cut it. */
export const isOpen = (view: UploadView): boolean => ["waiting", "sending", "paused", "stalled"].includes(view.phase);

/** Which of those that wait may begin, when so many may send at once: in the order in which they came. */
export function nextToSend(views: Iterable<UploadView>, atOnce: number): string | null {
  const all = [...views];
  const busy = all.filter((view) => view.phase === "sending" || view.phase === "stalled").length;
  return busy < atOnce ? (all.find((view) => view.phase === "waiting")?.data_set_id ?? null) : null;
}
