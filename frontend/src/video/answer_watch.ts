import { signal } from "@preact/signals";
import type { After } from "../live/paced";

export interface AnswerParts {
  /** The newest input that was sent, and the one that the picture on the screen shows. */
  readonly sentInput: () => number;
  readonly shownInput: () => number;
  /** Whether the renderer owes this viewer a picture for each input. */
  readonly isOwed: () => boolean;
  readonly nowMs: () => number;
  readonly after: After;
}

const everyMs = 500;
/** With the interval, the user learns within 3 s that the renderer does not answer. */
const patienceMs = 2500;

/**
 * Notices that a change brings no new picture although the connection is open, for example because
 * the worker hangs.
 */
export class AnswerWatch {
  readonly late = signal(false);
  private refused = 0;
  private seen = 0;
  private sinceMs: number | null = null;
  private cancel: (() => void) | null = null;

  constructor(private readonly parts: AnswerParts) {}

  start(): void {
    this.cancel ??= this.parts.after(everyMs, () => {
      this.cancel = null;
      this.look();
      this.start();
    });
  }

  stop(): void {
    this.cancel?.();
    this.cancel = null;
    this.late.value = false;
  }

  /** Notes that the renderer has refused this input, so no picture will show it. */
  refuse(input: number): void {
    this.refused = Math.max(this.refused, input);
  }

  private look(): void {
    const { parts } = this;
    const shown = parts.shownInput();
    const waits = parts.isOwed() && shown > 0 && parts.sentInput() > Math.max(shown, this.refused);
    // While the user keeps dragging, each picture that arrives is an answer.
    if (!waits || shown !== this.seen) this.sinceMs = waits ? parts.nowMs() : null;
    else this.sinceMs ??= parts.nowMs();
    this.seen = shown;
    this.late.value = this.sinceMs !== null && parts.nowMs() - this.sinceMs >= patienceMs;
  }
}
