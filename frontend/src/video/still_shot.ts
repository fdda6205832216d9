import type { Abilities, Frame, Scene, Viewport } from "../protocol/messages";
import type { Door } from "../protocol/stream_client";
import { JpegDecoder } from "./jpeg";
import { LosslessEnd, type LosslessFacts, type TilePixels } from "./lossless_end";
import type { Picture } from "./picture";
import { sha256 } from "./sha256";
import { decode_still } from "./tile_pixels";
import { browser_unseen, UnseenSession, type UnseenParts, type UnseenState } from "./unseen";

/** What the protocol allows, pixels. */
export const shortest_side = 16;
export const longest_side = 4096;

export interface ShotOrder {
  readonly scene: Scene;
  readonly size: Viewport;
  /** Estimated relative error at which the picture is good enough (a smoothed one is nearer still); 0: the renderer's own end, without loss. */
  readonly error: number;
}

interface ShotDone {
  readonly kind: "done";
  readonly error: number;
  readonly samples: number;
  readonly lossless: boolean;
}
export type ShotState = UnseenState<ShotDone>;

/** Where the picture is put together. */
export interface Sheet {
  draw(picture: Picture): void;
  draw_tiles(tiles: readonly TilePixels[]): void;
}

export interface ShotParts extends UnseenParts<ShotState> {
  readonly decode: (frame: Frame) => Promise<Picture>;
  readonly decode_still: typeof decode_still;
  readonly sha256: typeof sha256;
  readonly stills: Abilities["stills"];
  readonly now_ms: () => number;
}

/** The noise halves with four times the samples: how much of the way is behind. */
export function part_done(error: number, wanted: number): number | null {
  if (!Number.isFinite(error) || error <= 0 || wanted <= 0) return null;
  return Math.min(1, (wanted / error) ** 2);
}

/** What the renderer itself takes for the end (docs/contracts.md). */
export const renderers_error = 0.01;

/** A picture of its own size beside the one that is looked at, until it is good enough. */
export class StillShot {
  private readonly session_: UnseenSession<ShotDone>;
  private readonly lossless_: LosslessEnd;
  private busy_ = false;
  private epoch_ = -1n;

  constructor(
    private readonly order_: ShotOrder,
    private readonly sheet_: Sheet,
    private readonly parts_: ShotParts,
  ) {
    this.lossless_ = new LosslessEnd({
      decode: parts_.decode_still,
      sha256: parts_.sha256,
      show: (tiles, facts) => this.show(tiles, facts),
      damaged: () => this.session_.fail("refused", ""),
      ack: (still, times, queue) => this.session_.client.ack(still, times, queue),
      now_ms: parts_.now_ms,
    });
    this.session_ = new UnseenSession(parts_, order_.size, parts_.stills, {
      config: () => {
        this.epoch_ = -1n;
        this.lossless_.reset();
      },
      frame: (frame) => void this.frame(frame),
      still: (still) => void this.lossless_.receive(still),
      problem: ({ message }) => this.session_.fail("refused_scene", message),
    });
    this.session_.client.remember(order_.scene, 1); // newer than what the session begins with
  }

  start(): void {
    this.session_.start();
  }

  stop(): void {
    this.session_.stop();
  }

  private async frame(frame: Frame): Promise<void> {
    const received_ms = this.parts_.now_ms();
    this.lossless_.epoch_is(frame.epoch);
    const own = frame.inputSeq > 1n && frame.width === this.order_.size.width && frame.height === this.order_.size.height;
    const samples = Number(frame.iteration);
    const wanted = this.order_.error || renderers_error;
    if (own && !this.session_.is_over()) {
      this.epoch_ = frame.epoch;
      this.session_.is_at(part_done(frame.error, wanted));
    }
    const enough = own && !this.session_.is_over() && !this.busy_ && frame.error <= this.order_.error; // 0: never, it ends with its tiles
    if (enough) {
      this.busy_ = true;
      try {
        const picture = await this.parts_.decode(frame);
        if (!this.session_.is_over()) {
          this.sheet_.draw(picture);
          this.session_.finish({ kind: "done", samples, error: frame.error, lossless: false });
        }
        picture.close();
      } catch {
        // A damaged frame: the next one may be whole.
      }
      this.busy_ = false;
    }
    const now = this.parts_.now_ms();
    this.session_.client.ack(frame, { received_ms, decoded_ms: now, presented_ms: now }, 0);
  }

  private show(tiles: readonly TilePixels[], facts: LosslessFacts): boolean {
    const { width, height } = this.order_.size;
    if (this.session_.is_over() || facts.epoch !== this.epoch_ || facts.width !== width || facts.height !== height) return false;
    this.sheet_.draw_tiles(tiles);
    this.session_.finish({ kind: "done", samples: facts.samples, error: facts.error, lossless: true });
    return true;
  }
}

/** With the browser's own parts, and an own session of the scan. */
export function browser_parts(door: Door, stills: Abilities["stills"], state: (state: ShotState) => void): ShotParts {
  const decoder = new JpegDecoder();
  return {
    ...browser_unseen(door, state),
    decode: (frame) => decoder.decode(frame),
    decode_still,
    sha256,
    stills,
    now_ms: () => performance.now(),
  };
}
