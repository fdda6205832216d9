import type { CodedPicture, FrameDecoder, Picture } from "./picture";

/** A picture that has not come out this long after it went in is pressed out. */
const stuck_after_ms = 200;

interface Pending {
  readonly resolve: (picture: Picture) => void;
  readonly reject: (why: Error) => void;
}

/** WebCodecs: in a secure context of a browser that has it. Configured by the key frames. */
export class H264Decoder implements FrameDecoder {
  readonly independent = false;
  private readonly decoder_: VideoDecoder;
  private readonly pending_ = new Map<number, Pending>();
  private configured_ = "";
  private chained_ = false;
  private stuck_: ReturnType<typeof setTimeout> | undefined;

  constructor() {
    this.decoder_ = new VideoDecoder({
      output: (frame) => this.came_out(frame),
      error: (error) => this.failed(error),
    });
  }

  static exists(): boolean {
    return typeof VideoDecoder === "function" && typeof EncodedVideoChunk === "function";
  }

  decode(frame: CodedPicture): Promise<Picture> {
    return new Promise((resolve, reject) => {
      try {
        if (frame.key) this.configure(frame.decoder);
        else if (!this.chained_) throw new Error("a frame without the key frame before it");
        const timestamp = Number(frame.seq); // only tells the outputs apart
        this.pending_.set(timestamp, { resolve, reject });
        this.decoder_.decode(new EncodedVideoChunk({ type: frame.key ? "key" : "delta", timestamp, data: frame.data }));
        this.chained_ = true;
        this.watch();
      } catch (error) {
        this.failed(error instanceof Error ? error : new Error(String(error)));
        reject(new Error("the H.264 decoder refused a frame"));
      }
    });
  }

  close(): void {
    this.failed(new Error("closed"));
    if (this.decoder_.state !== "closed") this.decoder_.close();
  }

  private configure(codec: string): void {
    if (codec === this.configured_) return; // a new size is told by the stream's own parameter sets
    // No description: the stream is Annex B. Nothing is held back for reordering, since nothing is reordered.
    this.decoder_.configure({ codec, optimizeForLatency: true });
    this.configured_ = codec;
  }

  private came_out(frame: VideoFrame): void {
    const waiting = this.pending_.get(frame.timestamp);
    this.pending_.delete(frame.timestamp);
    this.watch();
    if (!waiting) {
      frame.close();
      return;
    }
    waiting.resolve({ image: frame, width: frame.displayWidth, height: frame.displayHeight, close: () => frame.close() });
  }

  /** Some decoders in hardware keep the last picture until the next comes. A flush presses it out and breaks the chain. */
  private watch(): void {
    clearTimeout(this.stuck_);
    if (this.pending_.size === 0) return;
    this.stuck_ = setTimeout(() => {
      if (this.decoder_.state !== "configured" || this.decoder_.decodeQueueSize > 0) return;
      this.chained_ = false;
      this.decoder_.flush().catch(() => undefined); // told by `error`
    }, stuck_after_ms);
  }

  private failed(why: Error): void {
    clearTimeout(this.stuck_);
    this.chained_ = false;
    const waiting = [...this.pending_.values()];
    this.pending_.clear();
    for (const { reject } of waiting) reject(why);
  }
}
