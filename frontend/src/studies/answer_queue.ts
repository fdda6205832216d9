import { signal } from "@preact/signals";
import type { After } from "../live/paced";
import type { Answer } from "./definition";

export interface QueuedAnswer {
  readonly kind: "answer";
  readonly step: string;
  readonly value: Answer;
  readonly duration_ms: number;
  readonly sequence: number;
}
export interface QueuedRecording {
  readonly kind: "recording";
  readonly step: string;
  readonly recording: object;
}
export type Queued = QueuedAnswer | QueuedRecording;

/** What became of a request: it may be repeated, it never succeeds, or the study is over for this participant. */
export type Failure =
  | { readonly kind: "again"; readonly retryAfterMs: number }
  | { readonly kind: "refused" }
  | { readonly kind: "over"; readonly why: Over };

/** Why the study takes nothing more: it is closed and may open again, or it no longer knows this participant. */
export type Over = "over" | "gone";

export interface QueueParts {
  readonly store: Pick<Storage, "getItem" | "setItem" | "removeItem">;
  readonly key: string;
  /** Sends one item. Rejects if the server has not acknowledged it. */
  readonly send: (item: Queued) => Promise<void>;
  readonly failureOf: (thrown: unknown) => Failure;
  readonly after: After;
}

const firstWaitMs = 1000;
const longestWaitMs = 15_000;

/**
 * The answers that the server has not acknowledged yet. They survive a reload, and are sent in order and repeated until
 * they are acknowledged.
 */
export class AnswerQueue {
  readonly pending = signal<readonly Queued[]>([]);
  /** Whether the last attempt failed, so that the participant should know. */
  readonly waiting = signal(false);
  /** The steps whose answers the server does not accept. */
  readonly refused = signal<readonly string[]>([]);
  /** Why the study takes no more answers of this participant, or null while it does. */
  readonly over = signal<Over | null>(null);

  private sequence = 0;
  private busy = false;
  private stopped = false;
  private failures = 0;
  private stopTimer: () => void = () => undefined;
  private emptied: (() => void)[] = [];

  constructor(private readonly parts: QueueParts) {
    try {
      const kept = JSON.parse(parts.store.getItem(parts.key) ?? "null") as {
        pending: Queued[];
        sequence: number;
      } | null;
      if (Array.isArray(kept?.pending) && Number.isSafeInteger(kept.sequence)) {
        this.pending.value = kept.pending;
        this.sequence = kept.sequence;
      }
    } catch {
      // The stored text is damaged, so there is nothing to continue with.
    }
  }

  /** Continues after the answers that the server has, should this tab have lost its count. */
  continueAfter(sequence: number): void {
    this.sequence = Math.max(this.sequence, sequence);
  }

  answer(step: string, value: Answer, durationMs: number): void {
    this.sequence += 1;
    this.add({ kind: "answer", step, value, duration_ms: Math.round(durationMs), sequence: this.sequence });
  }

  record(step: string, recording: object): void {
    this.add({ kind: "recording", step, recording });
  }

  /** Resolves when the server has everything, or the study is over. */
  whenEmpty(): Promise<void> {
    if (this.pending.value.length === 0 || this.over.value !== null) return Promise.resolve();
    this.wake();
    return new Promise((resolve) => this.emptied.push(resolve));
  }

  /** Tries again at once, for example when the network is back. */
  wake(): void {
    this.stopTimer();
    void this.next();
  }

  /** Ends all attempts. What is pending stays in the store. */
  stop(): void {
    this.stopped = true;
    this.stopTimer();
  }

  /** Forgets everything, after a withdrawal. */
  clear(): void {
    this.stop();
    this.parts.store.removeItem(this.parts.key);
    this.pending.value = [];
    this.settle();
  }

  private add(item: Queued): void {
    if (this.over.value !== null || this.stopped) return;
    this.stopTimer();
    this.keep([...this.pending.value, item]);
    void this.next();
  }

  private keep(pending: readonly Queued[]): void {
    this.pending.value = pending;
    this.parts.store.setItem(this.parts.key, JSON.stringify({ pending, sequence: this.sequence }));
    if (pending.length === 0) this.settle();
  }

  private settle(): void {
    for (const resolve of this.emptied.splice(0)) resolve();
  }

  private async next(): Promise<void> {
    const item = this.pending.value[0];
    if (!item || this.busy || this.stopped || this.over.value !== null) return;
    this.busy = true;
    let failure: Failure | null = null;
    try {
      await this.parts.send(item);
    } catch (thrown) {
      failure = this.parts.failureOf(thrown);
    }
    this.busy = false;
    if (this.isStopped()) return; // another page of this tab continues, or everything is forgotten
    if (failure?.kind === "again") this.retryLater(failure.retryAfterMs);
    else if (failure?.kind === "over") this.end(failure.why);
    else {
      if (failure && item.kind === "answer") this.refused.value = [...this.refused.value, item.step];
      this.failures = 0;
      this.waiting.value = false;
      this.keep(this.pending.value.filter((one) => one !== item));
      void this.next();
    }
  }

  /** A function, because the compiler assumes that a property does not change while something is awaited. */
  private isStopped(): boolean {
    return this.stopped;
  }

  /** Ends all attempts. What a closed study has not taken stays in the store, because it may open again. */
  end(why: Over): void {
    this.stopTimer();
    this.over.value = why;
    this.waiting.value = false;
    if (why === "gone") this.keep([]);
    this.settle();
  }

  private retryLater(retryAfterMs: number): void {
    this.waiting.value = true;
    const wait = Math.min(longestWaitMs, Math.max(firstWaitMs * 2 ** this.failures, retryAfterMs));
    this.failures += 1;
    if (!this.stopped) this.stopTimer = this.parts.after(wait, () => void this.next());
  }
}
