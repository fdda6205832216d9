import type { Codec, Frame, FrameTimes } from "../protocol/messages";
import type { FrameDecoder } from "./picture";

export interface FramePipelineParts<P extends { close(): void }> {
  /** Returns null for a codec that is unknown or that this browser lacks. */
  readonly makeDecoder: (codec: Codec) => FrameDecoder<P> | null;
  readonly present: (picture: P, frame: Frame) => void;
  readonly ack: (frame: Frame, times: FrameTimes, queue: number) => void;
  /** Requests a key frame, because earlier frames cannot be decoded. */
  readonly needKey: () => void;
  /** Called if a codec has failed too often and should no longer be used. */
  readonly giveUp: (codec: Codec) => void;
  readonly nowMs: () => number;
}

interface Arrival {
  readonly frame: Frame;
  readonly receivedMs: number;
}

/**
 * Maximum number of frames of a chained codec that wait to be decoded. The server keeps two in flight, so a device with
 * more cannot keep up.
 */
export const longestQueue = 3;
/**
 * Number of consecutive failures after which a codec is given up, and of good frames after which old failures no longer
 * count.
 */
export const mostFailures = 3;
export const forgottenAfter = 60;

/**
 * Brings frames from the stream to the screen. Independent frames are decoded one at a time and only the newest one
 * waits, so a slow device shows fewer pictures, but never old ones. Chained frames are all decoded, in order. If too
 * many wait, all are skipped until the next key frame. The picture never goes back to an older epoch (no ghosting) or
 * an older frame.
 */
export class FramePipeline<P extends { close(): void }> {
  private connection = 0;
  private shown = { epoch: 0n, seq: 0n };
  private decoder: { codec: Codec; made: FrameDecoder<P> } | null = null;
  private decoding = 0;
  private waiting: Arrival | null = null; // a frame of a codec with independent frames
  private wantsKey = false;
  private failures = 0;
  private good = 0;

  constructor(private readonly parts: FramePipelineParts<P>) {}

  /**
   * Starts again on a new connection, whose epochs and frames are counted from the beginning.
   * Frames that are being decoded belong to the old one.
   */
  reset(): void {
    this.connection += 1;
    this.shown = { epoch: 0n, seq: 0n };
    this.waiting = null;
    this.dropDecoder();
    this.wantsKey = false; // the first frame of a connection is a key frame
  }

  receive(frame: Frame): void {
    const arrival = { frame, receivedMs: this.parts.nowMs() };
    const decoder = this.decoderFor(frame.codec);
    if (!decoder) {
      this.ackDropped(arrival);
      this.failed(frame.codec);
    } else if (decoder.independent) this.receiveAlone(arrival, decoder);
    else this.receiveChained(arrival, decoder);
  }

  close(): void {
    this.connection += 1;
    this.waiting = null;
    this.dropDecoder();
  }

  private decoderFor(codec: Codec): FrameDecoder<P> | null {
    if (this.decoder?.codec === codec) return this.decoder.made;
    this.dropDecoder();
    let made: FrameDecoder<P> | null = null;
    try {
      made = this.parts.makeDecoder(codec);
    } catch {
      // Treated like a missing decoder.
    }
    this.decoder = made && { codec, made };
    return made;
  }

  private dropDecoder(): void {
    this.decoder?.made.close();
    this.decoder = null;
    this.decoding = 0;
    if (this.waiting) this.ackDropped(this.waiting);
    this.waiting = null;
  }

  private receiveAlone(arrival: Arrival, decoder: FrameDecoder<P>): void {
    if (this.decoding > 0) {
      if (this.waiting) this.ackDropped(this.waiting);
      this.waiting = arrival;
    } else void this.decode(arrival, decoder);
  }

  private receiveChained(arrival: Arrival, decoder: FrameDecoder<P>): void {
    const { key } = arrival.frame;
    if (this.decoding >= longestQueue) {
      // Discards all waiting frames, because a new decoder starts at the next key frame.
      this.decoder = null;
      this.decoding = 0;
      decoder.close();
      if (!key) this.askKey();
    }
    if (this.wantsKey && !key) {
      this.ackDropped(arrival);
      return;
    }
    this.wantsKey = false;
    const able = this.decoderFor(arrival.frame.codec);
    if (able) void this.decode(arrival, able);
    else this.ackDropped(arrival);
  }

  private async decode(arrival: Arrival, decoder: FrameDecoder<P>): Promise<void> {
    const connection = this.connection;
    this.decoding += 1;
    let picture: P | null = null;
    try {
      picture = await decoder.decode(arrival.frame);
    } catch {
      // The missing picture reports the failure.
    }
    const current = this.decoder?.made === decoder;
    if (current) this.decoding -= 1;
    if (connection === this.connection) {
      if (picture) this.finish(arrival, picture);
      else this.ackDropped(arrival);
      if (current && picture) this.succeeded();
      if (current && !picture) this.failed(arrival.frame.codec);
    }
    picture?.close();
    const next = this.waiting;
    if (next && current && this.decoding === 0) {
      this.waiting = null;
      this.receiveAlone(next, this.decoder?.made ?? decoder);
    }
  }

  private finish({ frame, receivedMs }: Arrival, picture: P): void {
    const decodedMs = this.parts.nowMs();
    const { epoch, seq } = this.shown;
    if (frame.epoch < epoch || (frame.epoch === epoch && frame.seq < seq)) {
      this.parts.ack(frame, { receivedMs, decodedMs }, this.queue());
      return;
    }
    this.shown = { epoch: frame.epoch, seq: frame.seq };
    this.parts.present(picture, frame);
    this.parts.ack(frame, { receivedMs, decodedMs, presentedMs: this.parts.nowMs() }, this.queue());
  }

  private succeeded(): void {
    if (this.failures > 0 && ++this.good >= forgottenAfter) this.failures = 0;
  }

  /**
   * Counts a failure. The next frame replaces an independent one. A broken chain starts again at a
   * key frame.
   */
  private failed(codec: Codec): void {
    this.good = 0;
    this.failures += 1;
    if (this.decoder?.made.independent !== true) {
      this.dropDecoder();
      this.askKey();
    }
    if (this.failures < mostFailures) return;
    this.failures = 0;
    this.parts.giveUp(codec);
  }

  private askKey(): void {
    if (this.wantsKey) return;
    this.wantsKey = true;
    this.parts.needKey();
  }

  private ackDropped({ frame, receivedMs }: Arrival): void {
    this.parts.ack(frame, { receivedMs }, this.queue());
  }

  private queue(): number {
    return this.decoding + (this.waiting ? 1 : 0);
  }
}
