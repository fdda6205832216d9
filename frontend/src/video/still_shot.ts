import { open_browser_socket } from "../protocol/browser_socket";
import type { Trouble } from "../protocol/connection";
import { Codec, type Abilities, type Frame, type Scene, type Viewport } from "../protocol/messages";
import { StreamClient, type Door, type OpenSocket } from "../protocol/stream_client";
import { JpegDecoder } from "./jpeg";
import { LosslessEnd, type LosslessFacts, type TilePixels } from "./lossless_end";
import type { Picture } from "./picture";
import { sha256 } from "./sha256";
import { decode_still } from "./tile_pixels";
import { unheard } from "./unseen";

/** What the protocol allows, pixels. */
export const shortest_side = 16;
export const longest_side = 4096;

export interface ShotOrder {
  readonly scene: Scene;
  readonly size: Viewport;
  /** Estimated relative error at which the picture is good enough (a smoothed one is nearer still); 0: the renderer's own end, without loss. */
  readonly error: number;
}

export type ShotState =
  /** `done`: 0 to 1, nothing: not known yet. `waits`: why nothing goes on just now. */
  | { readonly kind: "rendering"; readonly done: number | null; readonly waits: Trouble | null }
  | { readonly kind: "done"; readonly error: number; readonly samples: number; readonly lossless: boolean }
  | { readonly kind: "failed"; readonly trouble: Trouble | "refused_scene" | "stopped"; readonly said: string };

/** Where the picture is put together. */
export interface Sheet {
  draw(picture: Picture): void;
  draw_tiles(tiles: readonly TilePixels[]): void;
}

export interface ShotParts {
  readonly door: Door;
  readonly open_socket: OpenSocket;
  readonly after: (ms: number, task: () => void) => () => void;
  readonly decode: (frame: Frame) => Promise<Picture>;
  readonly decode_still: typeof decode_still;
  readonly sha256: typeof sha256;
  readonly stills: Abilities["stills"];
  readonly now_ms: () => number;
  readonly state: (state: ShotState) => void;
}

/** The noise halves with four times the samples: how much of the way is behind. */
export function part_done(error: number, wanted: number): number | null {
  if (!Number.isFinite(error) || error <= 0 || wanted <= 0) return null;
  return Math.min(1, (wanted / error) ** 2);
}

/** What the renderer itself takes for the end (docs/contracts.md). */
export const renderers_error = 0.01;

/**
 * A picture of its own size beside the one that is looked at: a session more of the same scan, which nobody sees, until
 * its picture is good enough. It is the person's render time, and ends with it.
 */
export class StillShot {
  private readonly client_: StreamClient;
  private readonly lossless_: LosslessEnd;
  private over_ = false;
  private busy_ = false;
  private epoch_ = -1n;
  private done_: number | null = null;
  private waits_: Trouble | null = null;

  constructor(
    private readonly order_: ShotOrder,
    private readonly sheet_: Sheet,
    private readonly parts_: ShotParts,
  ) {
    this.lossless_ = new LosslessEnd({
      decode: parts_.decode_still,
      sha256: parts_.sha256,
      show: (tiles, facts) => this.show(tiles, facts),
      damaged: () => this.fail("refused", ""),
      ack: (still, times, queue) => this.client_.ack(still, times, queue),
      now_ms: parts_.now_ms,
    });
    this.client_ = new StreamClient(
      {
        door: parts_.door,
        open_socket: parts_.open_socket,
        next_frame: (task) => void parts_.after(0, task), // also while nobody looks at the page
        after: parts_.after,
        chance: Math.random,
        abilities: { codecs: [Codec.JPEG], stills: parts_.stills }, // each frame stands alone
        pixel_ratio: () => 1,
      },
      {
        ...unheard,
        connection: ({ phase, trouble }) => {
          if (trouble !== null && (phase === "stopped" || phase === "elsewhere")) this.fail(trouble, "");
          else if (!this.over_ && trouble !== this.waits_) {
            this.waits_ = trouble;
            this.tell();
          }
        },
        config: () => {
          this.epoch_ = -1n;
          this.lossless_.reset();
        },
        frame: (frame) => void this.frame(frame),
        still: (still) => void this.lossless_.receive(still),
        problem: ({ message }) => this.fail("refused_scene", message),
      },
      order_.size,
    );
    this.client_.remember(order_.scene, 1); // newer than what the session begins with
  }

  start(): void {
    this.tell();
    this.client_.start();
  }

  stop(): void {
    this.fail("stopped", "");
  }

  private async frame(frame: Frame): Promise<void> {
    const received_ms = this.parts_.now_ms();
    this.lossless_.epoch_is(frame.epoch);
    const own = frame.inputSeq > 1n && frame.width === this.order_.size.width && frame.height === this.order_.size.height;
    const samples = Number(frame.iteration);
    const wanted = this.order_.error || renderers_error;
    if (own && !this.over_) {
      this.epoch_ = frame.epoch;
      this.done_ = part_done(frame.error, wanted);
      this.tell();
    }
    const enough = own && !this.over_ && !this.busy_ && frame.error <= this.order_.error; // 0: never, it ends with its tiles
    if (enough) {
      this.busy_ = true;
      try {
        const picture = await this.parts_.decode(frame);
        if (!this.over_) {
          this.sheet_.draw(picture);
          this.finish({ kind: "done", samples, error: frame.error, lossless: false });
        }
        picture.close();
      } catch {
        // A damaged frame: the next one may be whole.
      }
      this.busy_ = false;
    }
    const now = this.parts_.now_ms();
    this.client_.ack(frame, { received_ms, decoded_ms: now, presented_ms: now }, 0);
  }

  private show(tiles: readonly TilePixels[], facts: LosslessFacts): boolean {
    const { width, height } = this.order_.size;
    if (this.over_ || facts.epoch !== this.epoch_ || facts.width !== width || facts.height !== height) return false;
    this.sheet_.draw_tiles(tiles);
    this.finish({ kind: "done", samples: facts.samples, error: facts.error, lossless: true });
    return true;
  }

  private tell(): void {
    this.parts_.state({ kind: "rendering", done: this.done_, waits: this.waits_ });
  }

  private fail(trouble: Trouble | "refused_scene" | "stopped", said: string): void {
    this.finish({ kind: "failed", trouble, said });
  }

  private finish(state: ShotState): void {
    if (this.over_) return;
    this.over_ = true;
    this.client_.stop();
    this.parts_.state(state);
  }
}

/** With the browser's own parts, and an own session of the scan. */
export function browser_parts(door: Door, stills: Abilities["stills"], state: (state: ShotState) => void): ShotParts {
  const decoder = new JpegDecoder();
  return {
    door,
    open_socket: open_browser_socket,
    after: (ms, task) => {
      const timer = setTimeout(task, ms);
      return () => clearTimeout(timer);
    },
    decode: (frame) => decoder.decode(frame),
    decode_still,
    sha256,
    stills,
    now_ms: () => performance.now(),
    state,
  };
}
