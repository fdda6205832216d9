import type { Frame, FrameTimes } from "../protocol/messages";

/** A decoded picture; `close` gives its memory back. */
export interface Picture {
  readonly width: number;
  readonly height: number;
  close(): void;
}

export interface FramePipelineParts<P extends Picture> {
  /** Rejects on a damaged picture. */
  readonly decode: (frame: Frame) => Promise<P>;
  readonly present: (picture: P, frame: Frame) => void;
  readonly ack: (frame: Frame, times: FrameTimes, queue: number) => void;
  readonly now_ms: () => number;
}

/**
 * From a frame of the stream to the screen. One is decoded at a time and only the newest waits, so a slow device
 * shows fewer pictures, never old ones. A frame of an older epoch is never shown: nothing ghosts.
 */
export class FramePipeline<P extends Picture> {
  private newest_epoch_ = 0n;
  private connection_ = 0;
  private decoding_ = false;
  private waiting_: { frame: Frame; received_ms: number } | null = null;

  constructor(private readonly parts_: FramePipelineParts<P>) {}

  /** A new connection: epochs count anew, and what is under way belongs to the old one. */
  reset(): void {
    this.newest_epoch_ = 0n;
    this.connection_ += 1;
    this.waiting_ = null;
  }

  receive(frame: Frame): void {
    const received_ms = this.parts_.now_ms();
    if (frame.epoch < this.newest_epoch_) {
      this.parts_.ack(frame, { received_ms }, 0);
      return;
    }
    this.newest_epoch_ = frame.epoch;
    if (this.waiting_) this.parts_.ack(this.waiting_.frame, { received_ms: this.waiting_.received_ms }, 1);
    this.waiting_ = { frame, received_ms };
    if (!this.decoding_) void this.drain();
  }

  private async drain(): Promise<void> {
    this.decoding_ = true;
    for (let next = this.take(); next; next = this.take()) {
      const connection = this.connection_;
      let picture: P | null = null;
      try {
        picture = await this.parts_.decode(next.frame);
      } catch {
        // Damaged: the next one replaces it.
      }
      if (connection === this.connection_) this.finish(next.frame, next.received_ms, picture);
      picture?.close();
    }
    this.decoding_ = false;
  }

  private take(): { frame: Frame; received_ms: number } | null {
    const next = this.waiting_;
    this.waiting_ = null;
    return next;
  }

  private finish(frame: Frame, received_ms: number, picture: P | null): void {
    const queue = this.waiting_ ? 1 : 0;
    if (!picture) {
      this.parts_.ack(frame, { received_ms }, queue);
      return;
    }
    const decoded_ms = this.parts_.now_ms();
    if (frame.epoch < this.newest_epoch_) {
      this.parts_.ack(frame, { received_ms, decoded_ms }, queue);
      return;
    }
    this.parts_.present(picture, frame);
    this.parts_.ack(frame, { received_ms, decoded_ms, presented_ms: this.parts_.now_ms() }, queue);
  }
}
