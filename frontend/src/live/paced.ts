/** Runs `task` after `ms`. Returns a function that cancels it. */
export type After = (ms: number, task: () => void) => () => void;

/** The browser's timer. */
export const after: After = (ms, task) => {
  const timer = setTimeout(task, ms);
  return () => clearTimeout(timer);
};

/** Passes on values at most every `everyMs`. Between these times, the newest value replaces earlier ones. */
export class Paced<Value> {
  private waiting: { readonly value: Value } | null = null;
  private cancel: (() => void) | null = null;

  constructor(
    private readonly everyMs: number,
    private readonly after: After,
    private readonly pass: (value: Value) => void,
  ) {}

  push(value: Value): void {
    this.waiting = { value };
    if (!this.cancel) this.passOn();
  }

  /** Drops a waiting value. */
  stop(): void {
    this.cancel?.();
    this.cancel = null;
    this.waiting = null;
  }

  private passOn(): void {
    this.cancel = null;
    if (!this.waiting) return;
    const { value } = this.waiting;
    this.waiting = null;
    this.cancel = this.after(this.everyMs, () => this.passOn());
    this.pass(value);
  }
}
