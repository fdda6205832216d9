import type { UploadView } from "./upload_view";

/** A message between the windows of one browser. It never leaves the browser. */
interface Word {
  readonly sent: readonly UploadView[];
  readonly ended: readonly string[];
  /** The sender has just been opened. Windows that send an upload report their progress at once. */
  readonly ask: boolean;
}

/** The browser features that the coordination uses. Either may be missing: locks exist only in secure contexts. */
export interface BetweenWindows {
  readonly locks: Pick<LockManager, "request" | "query"> | null;
  readonly channel: Pick<BroadcastChannel, "postMessage" | "onmessage"> | null;
  nowMs(): number;
}

export function thisBrowser(): BetweenWindows {
  return {
    locks: (navigator as { readonly locks?: LockManager }).locks ?? null,
    channel: typeof BroadcastChannel === "undefined" ? null : new BroadcastChannel("diaphane.uploads"),
    nowMs: () => Date.now(),
  };
}

/**
 * Coordinates the windows of this browser, so that no two send the same upload and each shows the progress of all. The
 * window that sends an upload holds a browser lock, which survives sleeping timers and ends with the window. Progress is
 * broadcast.
 */
export class TabCoordinator {
  private readonly others = new Map<string, { readonly view: UploadView; readonly atMs: number }>();
  private readonly releases = new Map<string, () => void>();

  /**
   * Begins to coordinate. `changed` is called when the uploads of other windows have changed, and
   * `own` returns this window's uploads.
   */
  constructor(
    private readonly changed: () => void,
    private readonly own: () => readonly UploadView[],
    private readonly between: BetweenWindows = thisBrowser(),
  ) {
    if (!between.channel) return;
    between.channel.onmessage = (event: MessageEvent<Word>) => this.hear(event.data);
    this.say({ sent: [], ended: [], ask: true });
  }

  /** Returns whether this window may send the upload. If so, no other window may until `release`. */
  claim(id: string): Promise<boolean> {
    const { locks } = this.between;
    if (!locks) return Promise.resolve(!this.views().some((view) => view.data_set_id === id));
    return new Promise((resolve, reject) => {
      locks
        .request(lockName(id), { ifAvailable: true }, (lock) => {
          resolve(lock !== null);
          return lock === null ? undefined : new Promise<void>((release) => this.releases.set(id, release));
        })
        .catch(reject);
    });
  }

  release(id: string): void {
    this.releases.get(id)?.();
    this.releases.delete(id);
    this.say({ sent: [], ended: [id], ask: false });
  }

  /** Sends the progress of this window's uploads to the other windows. */
  broadcast(): void {
    const sent = this.own();
    if (sent.length > 0) this.say({ sent: sent.map((view) => ({ ...view, marks: [] })), ended: [], ask: false });
  }

  /** Returns the uploads that other windows are sending. */
  views(): readonly UploadView[] {
    const since = this.between.locks ? -Infinity : this.between.nowMs() - silentMs;
    return [...this.others.values()].filter(({ atMs }) => atMs > since).map(({ view }) => view);
  }

  /** Forgets the uploads of windows that were closed without a message. The caller runs it periodically. */
  async forgetClosedTabs(): Promise<void> {
    const others = [...this.others.keys()]; // first, to keep uploads that start meanwhile
    if (others.length === 0) return;
    if (this.between.locks) {
      const { held = [] } = await this.between.locks.query();
      const names = new Set(held.map(({ name }) => name));
      for (const id of others) if (!names.has(lockName(id))) this.others.delete(id);
    }
    this.changed();
  }

  private hear(word: Word): void {
    const atMs = this.between.nowMs();
    for (const view of word.sent) this.others.set(view.data_set_id, { view, atMs });
    for (const id of word.ended) this.others.delete(id);
    if (word.ask) this.broadcast();
    if (word.sent.length + word.ended.length > 0) this.changed();
  }

  private say(word: Word): void {
    this.between.channel?.postMessage(word);
  }
}

const lockName = (id: string) => `diaphane.upload.${id}`;

/**
 * Without locks, a window counts as closed after this silence. A background window may wake only once per minute, but
 * it also wakes whenever a part has been sent.
 */
const silentMs = 12_000;
