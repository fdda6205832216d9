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

/** Limits of the protocol, in pixels. */
export const shortestSide = 16;
export const longestSide = 4096;

export interface ShotOrder {
  readonly scene: Scene;
  readonly size: Viewport;
  /**
   * Estimated relative error at which the picture is finished (a denoised one is even closer to the final picture). 0
   * renders until the renderer stops by itself, and the result is lossless.
   */
  readonly error: number;
}

interface ShotDone {
  readonly kind: "done";
  readonly error: number;
  readonly samples: number;
  readonly lossless: boolean;
}
export type ShotState = BackgroundState<ShotDone>;

/** The canvas on which the picture is assembled. */
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

/** Returns the fraction of the work that is done, given that four times the samples halve the noise. */
export function partDone(error: number, target: number): number | null {
  if (!Number.isFinite(error) || error <= 0 || target <= 0) return null;
  return Math.min(1, (target / error) ** 2);
}

/** The error at which the renderer stops by default (docs/contracts.md). */
export const renderersError = 0.01;

/** Renders a picture of any size in a separate session until it is finished. */
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
    this.session.client.remember(order.scene, 1); // newer than the initial scene of the session
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
    const target = this.order.error || renderersError;
    if (own && !this.session.isOver()) {
      this.epoch = frame.epoch;
      this.session.reportProgress(partDone(frame.error, target));
    }
    const enough = own && !this.session.isOver() && !this.busy && frame.error <= this.order.error; // an error of 0 is never reached, and the tiles end the picture
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
        // Ignores a damaged frame, because the next one may be intact.
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

/** Returns the browser's own canvas and a separate session of the scan. */
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
