import { openBrowserSocket } from "../protocol/browser_socket";
import type { Trouble } from "../protocol/connection";
import { Codec, type Abilities, type Viewport } from "../protocol/messages";
import { StreamClient, type TicketSource, type OpenSocket } from "../protocol/stream_client";
import type { StreamEvents } from "../protocol/stream_events";

const nothing = () => undefined;

/** A background session ignores the events that only a visible picture needs. */
const ignoredEvents: StreamEvents = {
  connection: nothing,
  config: nothing,
  frame: nothing,
  still: nothing,
  slice: nothing,
  slicesStale: nothing,
  audience: nothing,
  look: nothing,
  state: nothing,
  stats: nothing,
  problem: nothing,
  fileProgress: nothing,
  filePart: nothing,
  kernel: nothing,
  errorCurve: nothing,
  shared: nothing,
  markSight: nothing,
  labels: nothing,
  goodViews: nothing,
  volumePhases: nothing,
};

/** The progress of a background session. `Done` is its result, `Reason` a reason to fail that other sessions do not have. */
export type BackgroundState<Done, Reason extends string = never> =
  /** `done` is from 0 to 1, or null while it is unknown. `waits` is why nothing is rendered at the moment. */
  | { readonly kind: "rendering"; readonly done: number | null; readonly waits: Trouble | null }
  | Done
  | {
      readonly kind: "failed";
      readonly trouble: Trouble | "refused_scene" | "stopped" | Reason;
      readonly message: string;
    };

export interface BackgroundParts<State> {
  readonly ticketSource: TicketSource;
  readonly openSocket: OpenSocket;
  readonly after: (ms: number, task: () => void) => () => void;
  readonly state: (state: State) => void;
}

/**
 * A second session of the same scan that is not shown on the page. It renders one file to download,
 * uses the user's rendering time and ends when the file is complete.
 */
export class BackgroundSession<Done, Reason extends string = never> {
  readonly client: StreamClient;
  private over = false;
  private done: number | null = null;
  private waits: Trouble | null = null;

  constructor(
    private readonly parts: BackgroundParts<BackgroundState<Done, Reason>>,
    size: Viewport,
    stills: Abilities["stills"],
    onEvent: Partial<Omit<StreamEvents, "connection">>,
  ) {
    this.client = new StreamClient(
      {
        ticketSource: parts.ticketSource,
        openSocket: parts.openSocket,
        nextFrame: (task) => void parts.after(0, task), // also runs while the page is hidden
        after: parts.after,
        chance: Math.random,
        nowMs: () => performance.now(),
        probe: () => Promise.resolve(true), // a slow server is tolerated here
        abilities: { codecs: [Codec.JPEG], stills }, // each frame can be decoded on its own
        pixelRatio: () => 1,
      },
      {
        ...ignoredEvents,
        ...onEvent,
        connection: ({ phase, trouble }) => {
          if (trouble !== null && (phase === "stopped" || phase === "elsewhere")) this.fail(trouble, "");
          else if (trouble !== this.waits) {
            this.waits = trouble;
            this.report();
          }
        },
      },
      size,
    );
  }

  isOver(): boolean {
    return this.over;
  }

  start(): void {
    this.report();
    this.client.start();
  }

  stop(): void {
    this.fail("stopped", "");
  }

  reportProgress(done: number | null): void {
    this.done = done;
    this.report();
  }

  fail(trouble: Trouble | "refused_scene" | "stopped" | Reason, message: string): void {
    this.finish({ kind: "failed", trouble, message });
  }

  finish(state: BackgroundState<Done, Reason>): void {
    if (this.over) return;
    this.over = true;
    this.client.stop();
    this.parts.state(state);
  }

  private report(): void {
    if (!this.over) this.parts.state({ kind: "rendering", done: this.done, waits: this.waits });
  }
}

/** Returns the browser's own socket and timers for a background session. */
export const browserBackgroundParts = <State>(
  ticketSource: TicketSource,
  state: (state: State) => void,
): BackgroundParts<State> => ({
  ticketSource,
  openSocket: openBrowserSocket,
  after: (ms, task) => {
    const timer = setTimeout(task, ms);
    return () => clearTimeout(timer);
  },
  state,
});
