const withinMs = 2000;
/** The worker refuses more than four requests per second. */
const everyMs = 400;

/** Requests for the error curve of the current view. */
export class CurveRequest {
  private requestedMs = -Infinity;
  private came: () => void = () => undefined;

  constructor(
    private readonly ask: () => boolean,
    private readonly nowMs: () => number,
  ) {}

  /** Resolves with the answer, or without one after a while. Does not ask for a curve that is hardly older. */
  async refresh(): Promise<void> {
    const nowMs = this.nowMs();
    if (nowMs - this.requestedMs < everyMs || !this.ask()) return;
    this.requestedMs = nowMs;
    await new Promise<void>((resolve) => {
      this.came = resolve;
      setTimeout(resolve, withinMs);
    });
  }

  answered(): void {
    this.came();
  }
}
