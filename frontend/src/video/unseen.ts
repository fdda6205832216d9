import { open_browser_socket } from "../protocol/browser_socket";
import type { Trouble } from "../protocol/connection";
import { Codec, type Abilities, type Viewport } from "../protocol/messages";
import { StreamClient, type Door, type OpenSocket, type StreamEvents } from "../protocol/stream_client";

const nothing = () => undefined;

/** What a session that nobody sees has no use for. */
const unheard: StreamEvents = {
  connection: nothing,
  config: nothing,
  frame: nothing,
  still: nothing,
  slice: nothing,
  slices_stale: nothing,
  audience: nothing,
  look: nothing,
  state: nothing,
  stats: nothing,
  problem: nothing,
  file_progress: nothing,
  file_part: nothing,
  kernel: nothing,
};

/** How far a session is with what it is there for. `Done`: what comes of it; `Reason`: why it may fail beside what any may. */
export type UnseenState<Done, Reason extends string = never> =
  /** `done`: 0 to 1, nothing: not known yet. `waits`: why nothing goes on just now. */
  | { readonly kind: "rendering"; readonly done: number | null; readonly waits: Trouble | null }
  | Done
  | { readonly kind: "failed"; readonly trouble: Trouble | "refused_scene" | "stopped" | Reason; readonly said: string };

export interface UnseenParts<State> {
  readonly door: Door;
  readonly open_socket: OpenSocket;
  readonly after: (ms: number, task: () => void) => () => void;
  readonly state: (state: State) => void;
}

/**
 * A session more of the same scan, which nobody sees, for one thing that a person takes away. It is the person's render
 * time, and ends with that thing.
 */
export class UnseenSession<Done, Reason extends string = never> {
  readonly client: StreamClient;
  private over_ = false;
  private done_: number | null = null;
  private waits_: Trouble | null = null;

  constructor(
    private readonly parts_: UnseenParts<UnseenState<Done, Reason>>,
    size: Viewport,
    stills: Abilities["stills"],
    heard: Partial<Omit<StreamEvents, "connection">>,
  ) {
    this.client = new StreamClient(
      {
        door: parts_.door,
        open_socket: parts_.open_socket,
        next_frame: (task) => void parts_.after(0, task), // also while nobody looks at the page
        after: parts_.after,
        chance: Math.random,
        abilities: { codecs: [Codec.JPEG], stills }, // each frame stands alone
        pixel_ratio: () => 1,
      },
      {
        ...unheard,
        ...heard,
        connection: ({ phase, trouble }) => {
          if (trouble !== null && (phase === "stopped" || phase === "elsewhere")) this.fail(trouble, "");
          else if (trouble !== this.waits_) {
            this.waits_ = trouble;
            this.tell();
          }
        },
      },
      size,
    );
  }

  is_over(): boolean {
    return this.over_;
  }

  start(): void {
    this.tell();
    this.client.start();
  }

  stop(): void {
    this.fail("stopped", "");
  }

  is_at(done: number | null): void {
    this.done_ = done;
    this.tell();
  }

  fail(trouble: Trouble | "refused_scene" | "stopped" | Reason, said: string): void {
    this.finish({ kind: "failed", trouble, said });
  }

  finish(state: UnseenState<Done, Reason>): void {
    if (this.over_) return;
    this.over_ = true;
    this.client.stop();
    this.parts_.state(state);
  }

  private tell(): void {
    if (!this.over_) this.parts_.state({ kind: "rendering", done: this.done_, waits: this.waits_ });
  }
}

/** With the browser's own parts, and an own session of the scan. */
export const browser_unseen = <State>(door: Door, state: (state: State) => void): UnseenParts<State> => ({
  door,
  open_socket: open_browser_socket,
  after: (ms, task) => {
    const timer = setTimeout(task, ms);
    return () => clearTimeout(timer);
  },
  state,
});
