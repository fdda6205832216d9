/**
 * Time for which a server that owes an answer may be silent before it is probed, so that a loss is
 * known within 3 s.
 */
const quietMs = 1200;
/** Time limit of a probe. */
export const probeLimitMs = 1500;
/** The same after a successful probe: the server is only slow, for example because it compiles. */
const slowMs = 5000;

export interface SilenceDependencies {
  /** Whether the server can be reached at all. Gives up after `probeLimitMs`. */
  readonly probe: () => Promise<boolean>;
  readonly after: (ms: number, task: () => void) => () => void;
  readonly nowMs: () => number;
  /** Called if no message has arrived and the server can't be reached. */
  readonly lost: () => void;
}

/**
 * Notices that a connection is dead although it is still open. A browser takes minutes to close a WebSocket whose
 * network has gone, and shows no pings to a page.
 */
export class SilenceWatch {
  private due = false;
  private heardMs = 0;
  private waitMs = quietMs;
  private disarm: () => void = () => undefined;
  private probing = false;

  constructor(private readonly dependencies: SilenceDependencies) {}

  /** Notes that a message has arrived. */
  messageReceived(): void {
    this.heardMs = this.dependencies.nowMs();
    this.waitMs = quietMs;
  }

  /** Sets whether a message is due from now on. */
  expect(due: boolean): void {
    if (due === this.due) return;
    this.due = due;
    this.disarm();
    this.messageReceived();
    if (due) this.arm(this.waitMs);
  }

  /**
   * Probes now, because the browser has reported that the network is gone, which may not apply to a
   * server on this machine.
   */
  check(): void {
    if (this.probing) return;
    this.probing = true;
    const heardBefore = this.heardMs;
    void this.dependencies
      .probe()
      .catch(() => false)
      .then((reached) => {
        this.probing = false;
        if (!reached && this.heardMs === heardBefore) {
          this.expect(false);
          this.dependencies.lost();
        } else if (this.due) {
          this.waitMs = slowMs;
          this.arm(slowMs);
        }
      });
  }

  private arm(ms: number): void {
    this.disarm();
    this.disarm = this.dependencies.after(ms, () => {
      const left = this.heardMs + this.waitMs - this.dependencies.nowMs();
      if (left > 0) this.arm(left);
      else this.check();
    });
  }
}
