import type { Abilities, Frame, Scene, Viewport } from "../protocol/messages";
import type { TicketSource } from "../protocol/stream_client";
import { JpegDecoder } from "./jpeg";
import { LosslessAssembler, type LosslessFacts, type TilePixels } from "./lossless_assembler";
import type { Picture } from "./picture";
import { sha256 } from "./sha256";
import { decodeStill } from "./tile_pixels";
import {
  browserBackgroundParts,
  BackgroundSession,
  type BackgroundParts,
  type BackgroundState,
} from "./background_session";

/** What the protocol allows, pixels. */
export const shortestSide = 16;
export const longestSide = 4096;

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
export type ShotState = BackgroundState<ShotDone>;

/** Where the picture is put together. */
export interface Sheet {
  draw(picture: Picture): void;
  drawTiles(tiles: readonly TilePixels[]): void;
}

export interface ShotParts extends BackgroundParts<ShotState> {
  readonly decode: (frame: Frame) => Promise<Picture>;
  readonly decodeStill: typeof decodeStill;
  readonly sha256: typeof sha256;
  readonly stills: Abilities["stills"];
  readonly nowMs: () => number;
}

/** The noise halves with four times the samples: how much of the way is behind. */
export function partDone(error: number, wanted: number): number | null {
  if (!Number.isFinite(error) || error <= 0 || wanted <= 0) return null;
  return Math.min(1, (wanted / error) ** 2);
}

/** What the renderer itself takes for the end (docs/contracts.md). */
export const renderersError = 0.01;

/** A picture of its own size beside the one that is looked at, until it is good enough. */
export class StillShot {
  private readonly session: BackgroundSession<ShotDone>;
  private readonly lossless: LosslessAssembler;
  private busy = false;
  private epoch = -1n;

  constructor(
    private readonly order: ShotOrder,
    private readonly sheet: Sheet,
    private readonly parts: ShotParts,
  ) {
    this.lossless = new LosslessAssembler({
      decode: parts.decodeStill,
      sha256: parts.sha256,
      show: (tiles, facts) => this.show(tiles, facts),
      damaged: () => this.session.fail("refused", ""),
      ack: (still, times, queue) => this.session.client.ack(still, times, queue),
      nowMs: parts.nowMs,
    });
    this.session = new BackgroundSession(parts, order.size, parts.stills, {
      config: () => {
        this.epoch = -1n;
        this.lossless.reset();
      },
      frame: (frame) => void this.frame(frame),
      still: (still) => void this.lossless.receive(still),
      problem: ({ message }) => this.session.fail("refused_scene", message),
    });
    this.session.client.remember(order.scene, 1); // newer than what the session begins with
  }

  start(): void {
    this.session.start();
  }

  stop(): void {
    this.session.stop();
  }

  private async frame(frame: Frame): Promise<void> {
    const receivedMs = this.parts.nowMs();
    this.lossless.epochIs(frame.epoch);
    const own = frame.inputSeq > 1n && frame.width === this.order.size.width && frame.height === this.order.size.height;
    const samples = Number(frame.iteration);
    const wanted = this.order.error || renderersError;
    if (own && !this.session.isOver()) {
      this.epoch = frame.epoch;
      this.session.isAt(partDone(frame.error, wanted));
    }
    const enough = own && !this.session.isOver() && !this.busy && frame.error <= this.order.error; // 0: never, it ends with its tiles
    if (enough) {
      this.busy = true;
      try {
        const picture = await this.parts.decode(frame);
        if (!this.session.isOver()) {
          this.sheet.draw(picture);
          this.session.finish({ kind: "done", samples, error: frame.error, lossless: false });
        }
        picture.close();
      } catch {
        // A damaged frame: the next one may be whole.
      }
      this.busy = false;
    }
    const now = this.parts.nowMs();
    this.session.client.ack(frame, { receivedMs, decodedMs: now, presentedMs: now }, 0);
  }

  private show(tiles: readonly TilePixels[], facts: LosslessFacts): boolean {
    const { width, height } = this.order.size;
    if (this.session.isOver() || facts.epoch !== this.epoch || facts.width !== width || facts.height !== height)
      return false;
    this.sheet.drawTiles(tiles);
    this.session.finish({ kind: "done", samples: facts.samples, error: facts.error, lossless: true });
    return true;
  }
}

/** With the browser's own parts, and an own session of the scan. */
export function browserParts(
  ticketSource: TicketSource,
  stills: Abilities["stills"],
  state: (state: ShotState) => void,
): ShotParts {
  const decoder = new JpegDecoder();
  return {
    ...browserBackgroundParts(ticketSource, state),
    decode: (frame) => decoder.decode(frame),
    decodeStill,
    sha256,
    stills,
    nowMs: () => performance.now(),
  };
}
