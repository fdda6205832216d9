import type { OpenSocket } from "../protocol/stream_client";

export interface DelayClock {
  readonly nowMs: () => number;
  /** Runs `task` after this time. Returns a function that cancels it. */
  readonly after: (ms: number, task: () => void) => () => void;
}

interface Held {
  readonly dueMs: number;
  readonly deliver: () => void;
}

/**
 * Holds incoming messages for a time, in order. What this page sends is not delayed, so the viewer reacts as it would
 * over a network with a longer round trip.
 */
export class DelayLine {
  /** The delay of messages that arrive from now on. None of them overtakes an earlier one. */
  delayMs = 0;
  private held: Held[] = [];
  private stopTimer: (() => void) | null = null;

  constructor(private readonly clock: DelayClock) {}

  /** Returns `open` with the messages of its sockets delayed. A socket's end is reported after its messages. */
  around(open: OpenSocket): OpenSocket {
    return (url, events) =>
      open(url, {
        opened: () => events.opened(),
        message: (data) => this.hold(() => events.message(data)),
        closed: (code) => this.hold(() => events.closed(code)),
      });
  }

  private hold(deliver: () => void): void {
    if (this.delayMs <= 0 && this.held.length === 0) {
      deliver();
      return;
    }
    this.held.push({ dueMs: this.clock.nowMs() + this.delayMs, deliver });
    if (this.stopTimer === null) this.wait();
  }

  private wait(): void {
    const next = this.held[0];
    if (!next) return;
    this.stopTimer = this.clock.after(Math.max(0, next.dueMs - this.clock.nowMs()), () => {
      this.stopTimer = null;
      this.deliverDue();
      this.wait();
    });
  }

  private deliverDue(): void {
    const nowMs = this.clock.nowMs();
    // The first one is always due, even if the timer fired a fraction of a millisecond early.
    do this.held.shift()?.deliver();
    while ((this.held[0]?.dueMs ?? Infinity) <= nowMs);
  }
}
