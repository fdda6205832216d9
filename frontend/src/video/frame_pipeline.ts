import type { Codec, Frame, FrameTimes } from "../protocol/messages";
import type { FrameDecoder } from "./picture";

export interface FramePipelineParts<P extends { close(): void }> {
  /** Nothing for a codec that is not known here. */
  readonly make_decoder: (codec: Codec) => FrameDecoder<P> | null;
  readonly present: (picture: P, frame: Frame) => void;
  readonly ack: (frame: Frame, times: FrameTimes, queue: number) => void;
  /** A key frame is wanted: what comes before it cannot be decoded. */
  readonly need_key: () => void;
  /** A codec has failed too often: better to go on without it. */
  readonly give_up: (codec: Codec) => void;
  readonly now_ms: () => number;
}

interface Arrival {
  readonly frame: Frame;
  readonly received_ms: number;
}

/** Frames of a chained codec that may wait to be decoded. The server keeps two in flight, so more is a device that cannot follow. */
export const longest_queue = 3;
/** Failures in a row after which a codec is given up; and after so many good frames an old failure counts no more. */
export const most_failures = 3;
export const forgotten_after = 60;

/**
 * From a frame of the stream to the screen. Frames that stand alone are decoded one at a time and only the newest waits,
 * so a slow device shows fewer pictures, never old ones. Frames that build on each other are all decoded, in order; when
 * too many wait, all are left out up to the next key frame. What is shown never goes back: neither to an older epoch
 * (nothing ghosts) nor to an older frame.
 */
export class FramePipeline<P extends { close(): void }> {
  private connection_ = 0;
  private shown_ = { epoch: 0n, seq: 0n };
  private decoder_: { codec: Codec; made: FrameDecoder<P> } | null = null;
  private decoding_ = 0;
  private waiting_: Arrival | null = null; // of a codec whose frames stand alone
  private wants_key_ = false;
  private failures_ = 0;
  private good_ = 0;

  constructor(private readonly parts_: FramePipelineParts<P>) {}

  /** A new connection: epochs and frames count anew, and what is under way belongs to the old one. */
  reset(): void {
    this.connection_ += 1;
    this.shown_ = { epoch: 0n, seq: 0n };
    this.waiting_ = null;
    this.drop_decoder();
    this.wants_key_ = false; // the first frame of a connection is one
  }

  receive(frame: Frame): void {
    const arrival = { frame, received_ms: this.parts_.now_ms() };
    const decoder = this.decoder_for(frame.codec);
    if (!decoder) {
      this.ack_dropped(arrival);
      this.failed(frame.codec);
    } else if (decoder.independent) this.receive_alone(arrival, decoder);
    else this.receive_chained(arrival, decoder);
  }

  close(): void {
    this.connection_ += 1;
    this.waiting_ = null;
    this.drop_decoder();
  }

  private decoder_for(codec: Codec): FrameDecoder<P> | null {
    if (this.decoder_?.codec === codec) return this.decoder_.made;
    this.drop_decoder();
    let made: FrameDecoder<P> | null = null;
    try {
      made = this.parts_.make_decoder(codec);
    } catch {
      // As one that is not there.
    }
    this.decoder_ = made && { codec, made };
    return made;
  }

  private drop_decoder(): void {
    this.decoder_?.made.close();
    this.decoder_ = null;
    this.decoding_ = 0;
    if (this.waiting_) this.ack_dropped(this.waiting_);
    this.waiting_ = null;
  }

  private receive_alone(arrival: Arrival, decoder: FrameDecoder<P>): void {
    if (this.decoding_ > 0) {
      if (this.waiting_) this.ack_dropped(this.waiting_);
      this.waiting_ = arrival;
    } else void this.decode(arrival, decoder);
  }

  private receive_chained(arrival: Arrival, decoder: FrameDecoder<P>): void {
    const { key } = arrival.frame;
    if (this.decoding_ >= longest_queue) {
      // Nothing of what waits will be looked at: a new decoder begins at the next key frame.
      this.decoder_ = null;
      this.decoding_ = 0;
      decoder.close();
      if (!key) this.ask_key();
    }
    if (this.wants_key_ && !key) {
      this.ack_dropped(arrival);
      return;
    }
    this.wants_key_ = false;
    const able = this.decoder_for(arrival.frame.codec);
    if (able) void this.decode(arrival, able);
    else this.ack_dropped(arrival);
  }

  private async decode(arrival: Arrival, decoder: FrameDecoder<P>): Promise<void> {
    const connection = this.connection_;
    this.decoding_ += 1;
    let picture: P | null = null;
    try {
      picture = await decoder.decode(arrival.frame);
    } catch {
      // Told by there being no picture.
    }
    const current = this.decoder_?.made === decoder;
    if (current) this.decoding_ -= 1;
    if (connection === this.connection_) {
      if (picture) this.finish(arrival, picture);
      else this.ack_dropped(arrival);
      if (current && picture) this.succeeded();
      if (current && !picture) this.failed(arrival.frame.codec);
    }
    picture?.close();
    const next = this.waiting_;
    if (next && current && this.decoding_ === 0) {
      this.waiting_ = null;
      this.receive_alone(next, this.decoder_?.made ?? decoder);
    }
  }

  private finish({ frame, received_ms }: Arrival, picture: P): void {
    const decoded_ms = this.parts_.now_ms();
    const { epoch, seq } = this.shown_;
    if (frame.epoch < epoch || (frame.epoch === epoch && frame.seq < seq)) {
      this.parts_.ack(frame, { received_ms, decoded_ms }, this.queue());
      return;
    }
    this.shown_ = { epoch: frame.epoch, seq: frame.seq };
    this.parts_.present(picture, frame);
    this.parts_.ack(frame, { received_ms, decoded_ms, presented_ms: this.parts_.now_ms() }, this.queue());
  }

  private succeeded(): void {
    if (this.failures_ > 0 && ++this.good_ >= forgotten_after) this.failures_ = 0;
  }

  /** A frame that stands alone is replaced by the next; a chain is broken and begins anew at a key frame. */
  private failed(codec: Codec): void {
    this.good_ = 0;
    this.failures_ += 1;
    if (this.decoder_?.made.independent !== true) {
      this.drop_decoder();
      this.ask_key();
    }
    if (this.failures_ < most_failures) return;
    this.failures_ = 0;
    this.parts_.give_up(codec);
  }

  private ask_key(): void {
    if (this.wants_key_) return;
    this.wants_key_ = true;
    this.parts_.need_key();
  }

  private ack_dropped({ frame, received_ms }: Arrival): void {
    this.parts_.ack(frame, { received_ms }, this.queue());
  }

  private queue(): number {
    return this.decoding_ + (this.waiting_ ? 1 : 0);
  }
}
