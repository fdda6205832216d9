import type { UploadView } from "./upload_view";

/** What windows of one browser say to each other. Nothing leaves the browser. */
interface Word {
  readonly sent: readonly UploadView[];
  readonly ended: readonly string[];
  /** A window that has just been opened: whoever sends says so at once. */
  readonly ask: boolean;
}

/** What of the browser is needed; either may be missing: locks are there in secure contexts alone. */
export interface BetweenWindows {
  readonly locks: Pick<LockManager, "request" | "query"> | null;
  readonly channel: Pick<BroadcastChannel, "postMessage" | "onmessage"> | null;
  now_ms(): number;
}

export function this_browser(): BetweenWindows {
  return {
    locks: (navigator as { readonly locks?: LockManager }).locks ?? null,
    channel: typeof BroadcastChannel === "undefined" ? null : new BroadcastChannel("diaphane.uploads"),
    now_ms: () => Date.now(),
  };
}

/**
 * Which window of this browser sends which upload, so that no two send the same, and how far the others are, so that a
 * person sees it in each. Who sends holds a lock of the browser: that is true also of a window whose timers sleep, and over
 * when it is gone. How far it is, is only told.
 */
export class OtherWindows {
  private readonly heard_ = new Map<string, { readonly view: UploadView; readonly at_ms: number }>();
  private readonly release_ = new Map<string, () => void>();

  /** @param changed is called when what the others send has changed; @param own gives what this window sends. */
  constructor(
    private readonly changed_: () => void,
    private readonly own_: () => readonly UploadView[],
    private readonly between_: BetweenWindows = this_browser(),
  ) {
    if (!between_.channel) return;
    between_.channel.onmessage = (event: MessageEvent<Word>) => this.hear(event.data);
    this.say({ sent: [], ended: [], ask: true });
  }

  /** Whether this window may send it now; then no other may until `release`. */
  claim(id: string): Promise<boolean> {
    const { locks } = this.between_;
    if (!locks) return Promise.resolve(!this.views().some((view) => view.data_set_id === id));
    return new Promise((resolve, reject) => {
      locks
        .request(lock_name(id), { ifAvailable: true }, (lock) => {
          resolve(lock !== null);
          return lock === null ? undefined : new Promise<void>((release) => this.release_.set(id, release));
        })
        .catch(reject);
    });
  }

  release(id: string): void {
    this.release_.get(id)?.();
    this.release_.delete(id);
    this.say({ sent: [], ended: [id], ask: false });
  }

  /** To the others: how far what this window sends is. */
  tell(): void {
    const sent = this.own_();
    if (sent.length > 0) this.say({ sent: sent.map((view) => ({ ...view, marks: [] })), ended: [], ask: false });
  }

  /** What was heard, less what nobody sends any more. */
  views(): readonly UploadView[] {
    const since = this.between_.locks ? -Infinity : this.between_.now_ms() - silent_ms;
    return [...this.heard_.values()].filter(({ at_ms }) => at_ms > since).map(({ view }) => view);
  }

  /** Forgets the uploads of windows that have gone without a word. To be called every now and then. */
  async look(): Promise<void> {
    const heard = [...this.heard_.keys()]; // a lock younger than the answer is not missed
    if (heard.length === 0) return;
    if (this.between_.locks) {
      const { held = [] } = await this.between_.locks.query();
      const names = new Set(held.map(({ name }) => name));
      for (const id of heard) if (!names.has(lock_name(id))) this.heard_.delete(id);
    }
    this.changed_();
  }

  private hear(word: Word): void {
    const at_ms = this.between_.now_ms();
    for (const view of word.sent) this.heard_.set(view.data_set_id, { view, at_ms });
    for (const id of word.ended) this.heard_.delete(id);
    if (word.ask) this.tell();
    if (word.sent.length + word.ended.length > 0) this.changed_();
  }

  private say(word: Word): void {
    this.between_.channel?.postMessage(word);
  }
}

const lock_name = (id: string) => `diaphane.upload.${id}`;

/** Without locks, a window that was closed is known by its silence. One in the background may be woken only once a minute, but by each part. */
const silent_ms = 12_000;
