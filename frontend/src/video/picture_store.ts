import { signal } from "@preact/signals";
import type { ErrorCurve } from "../protocol/file_messages";
import type { Codec, Frame, FrameTimes, Still, Viewport } from "../protocol/messages";
import { FramePipeline } from "./frame_pipeline";
import { makeDecoder } from "./ladder";
import { LosslessAssembler, type LosslessFacts } from "./lossless_assembler";
import type { Painter } from "./painter";
import type { Picture } from "./picture";
import type { ErrorPoint, PictureFacts } from "./picture_facts";
import { withPoint } from "./plot_scale";
import { sha256 } from "./sha256";
import { decodeStill } from "./tile_pixels";

/** The part of the session that the pictures need. */
export interface PictureParts {
  readonly ack: (shown: Pick<Frame, "seq" | "epoch">, times: FrameTimes, queue: number) => void;
  readonly needKey: () => void;
  readonly giveUp: (codec: Codec) => void;
  /** Called if a lossless tile does not match its hash. */
  readonly damaged: () => void;
  readonly nowMs: () => number;
}

/** The pictures of one session: decodes and paints what arrives, and knows what is on the screen. */
export class PictureStore {
  readonly picture = signal<PictureFacts | null>(null);
  readonly curve = signal<readonly ErrorPoint[]>([]);
  readonly converged = signal(false);
  /** Set if the picture on the screen is exactly the rendered one. Each tile has been verified. */
  readonly lossless = signal<LosslessFacts | null>(null);

  private readonly pipeline: FramePipeline<Picture>;
  private readonly losslessAssembler: LosslessAssembler;
  private convergedEpoch = -1;
  /**
   * The first input whose pictures are shown. Reset to 0 once one was shown, because the next
   * presenter counts their own inputs.
   */
  private firstInput = 0;

  constructor(
    private readonly painter: Pick<Painter, "paint" | "paintExactly" | "resize" | "png">,
    parts: PictureParts,
  ) {
    this.pipeline = new FramePipeline<Picture>({
      makeDecoder,
      present: (picture, frame) => this.present(picture, frame),
      ack: parts.ack,
      needKey: parts.needKey,
      giveUp: parts.giveUp,
      nowMs: parts.nowMs,
    });
    this.losslessAssembler = new LosslessAssembler({
      decode: decodeStill,
      sha256,
      show: (tiles, facts) => {
        const shown = this.painter.paintExactly(tiles, facts);
        if (shown) this.presentLossless(facts);
        return shown;
      },
      damaged: parts.damaged,
      ack: parts.ack,
      nowMs: parts.nowMs,
    });
  }

  receive(frame: Frame): void {
    this.losslessAssembler.epochIs(frame.epoch);
    this.pipeline.receive(frame);
  }

  receiveStill(still: Still): void {
    void this.losslessAssembler.receive(still);
  }

  /** Notes which epoch has converged, or that none has. */
  setConverged(epoch: number | null): void {
    this.convergedEpoch = epoch ?? -1;
    this.converged.value = this.convergedEpoch === this.picture.value?.epoch;
  }

  /** Takes the worker's curve, if it is that of the shown view, and keeps what the pictures have shown since. */
  takeCurve({ epoch, points }: ErrorCurve): void {
    if (Number(epoch) !== this.picture.value?.epoch) return;
    const whole = points.map(({ samples, seconds, error }) => ({ samples: Number(samples), seconds, error }));
    this.curve.value = [...whole, ...this.curve.value].reduce(withPoint, []);
  }

  /** Starts with a new configuration and discards everything that arrived before it. */
  reset(): void {
    this.pipeline.reset();
    this.losslessAssembler.reset();
    this.convergedEpoch = -1;
    this.firstInput = 0;
  }

  /** Hides pictures of inputs before this one. 0 shows all pictures. */
  beginWith(inputSeq: number): void {
    this.firstInput = inputSeq;
  }

  resize(size: Viewport): void {
    this.painter.resize(size);
    this.lossless.value = null; // until the next picture, the shown one is scaled
  }

  png(): Promise<Blob | null> {
    return this.painter.png();
  }

  close(): void {
    this.pipeline.close();
  }

  private presentLossless(facts: LosslessFacts): void {
    const before = this.picture.value;
    if (before)
      this.picture.value = {
        ...before,
        samples: facts.samples,
        error: facts.error,
        width: facts.width,
        height: facts.height,
        smoothed: false,
      };
    this.lossless.value = facts;
  }

  private present(picture: Picture, frame: Frame): void {
    if (this.losslessAssembler.shows(frame.epoch) || frame.inputSeq < this.firstInput) return;
    this.firstInput = 0;
    this.painter.paint(picture);
    this.lossless.value = null;
    const before = this.picture.value;
    const facts: PictureFacts = {
      epoch: Number(frame.epoch),
      inputSeq: Number(frame.inputSeq),
      samples: Number(frame.iteration),
      error: frame.error,
      seconds: Number(frame.renderUs) / 1e6,
      width: frame.width,
      height: frame.height,
      smoothed: frame.denoised,
      stops: frame.stops,
      phase: frame.volumePhase,
    };
    this.picture.value = facts;
    const fresh = before?.epoch !== facts.epoch || before.samples > facts.samples;
    this.converged.value = this.convergedEpoch === facts.epoch;
    this.curve.value = withPoint(fresh ? [] : this.curve.value, facts);
  }
}
