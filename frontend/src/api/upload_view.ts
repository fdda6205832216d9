import { secondsLeft, withMark, type Mark } from "./pace";
import type { StallReason, UploadEnd } from "./upload";

/** The state of an upload, as the page shows it, and its transitions. Plain data without clock or network. */

/**
 * waiting: other uploads come first. paused: by the user. stalled: nothing gets through, and a retry follows.
 * elsewhere: another window of this browser sends it. sent: complete, but not yet in the list of scans. refused:
 * rejected permanently.
 */
export type UploadPhase = "waiting" | "sending" | "paused" | "stalled" | "elsewhere" | "sent" | "refused";

/** Why the server rejected the upload permanently. */
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

/**
 * Updates the progress. A stall ends when more bytes arrive than before it, not when a retry
 * begins.
 */
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

/** Returns the remaining seconds, or null if it is too early for an estimate. */
export const timeLeft = (view: UploadView): number | null =>
  view.phase === "sending" ? secondsLeft(view.marks, view.total) : null;

/** Whether closing the window would interrupt the upload. */
export const isOpen = (view: UploadView): boolean => ["waiting", "sending", "paused", "stalled"].includes(view.phase);

/** Returns the first waiting upload, or null if `atOnce` uploads are already being sent. */
export function nextToSend(views: Iterable<UploadView>, atOnce: number): string | null {
  const all = [...views];
  const busy = all.filter((view) => view.phase === "sending" || view.phase === "stalled").length;
  return busy < atOnce ? (all.find((view) => view.phase === "waiting")?.data_set_id ?? null) : null;
}
