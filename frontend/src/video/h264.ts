import type { CodedPicture, FrameDecoder, Picture } from "./picture";

/** A picture that the decoder holds back for longer is forced out with a flush. */
const stuckAfterMs = 200;

interface Pending {
  readonly resolve: (picture: Picture) => void;
  readonly reject: (why: Error) => void;
}

/**
 * Decodes H.264 with WebCodecs, which exists only in secure contexts. The key frames configure it.
 */
export class H264Decoder implements FrameDecoder {
  readonly independent = false;
  private readonly decoder: VideoDecoder;
  private readonly pending = new Map<number, Pending>();
  private configured = "";
  private chained = false;
  private stuck: ReturnType<typeof setTimeout> | undefined;

  constructor() {
    this.decoder = new VideoDecoder({
      output: (frame) => this.frameDecoded(frame),
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
        else if (!this.chained) throw new Error("a frame without the key frame before it");
        const timestamp = Number(frame.seq); // serves only to match the outputs with their frames
        this.pending.set(timestamp, { resolve, reject });
        this.decoder.decode(new EncodedVideoChunk({ type: frame.key ? "key" : "delta", timestamp, data: frame.data }));
        this.chained = true;
        this.watch();
      } catch (error) {
        this.failed(error instanceof Error ? error : new Error(String(error)));
        reject(new Error("the H.264 decoder refused a frame"));
      }
    });
  }

  close(): void {
    this.failed(new Error("closed"));
    if (this.decoder.state !== "closed") this.decoder.close();
  }

  private configure(codec: string): void {
    if (codec === this.configured) return; // the stream's own parameter sets contain a new size
    // Without a description, the stream is Annex B. No picture is held back for reordering, because the stream does not
    // reorder pictures.
    this.decoder.configure({ codec, optimizeForLatency: true });
    this.configured = codec;
  }

  private frameDecoded(frame: VideoFrame): void {
    const waiting = this.pending.get(frame.timestamp);
    this.pending.delete(frame.timestamp);
    this.watch();
    if (!waiting) {
      frame.close();
      return;
    }
    waiting.resolve({
      image: frame,
      width: frame.displayWidth,
      height: frame.displayHeight,
      close: () => frame.close(),
    });
  }

  /**
   * Forces out the last picture, which some hardware decoders keep until the next one arrives. A
   * flush breaks the chain.
   */
  private watch(): void {
    clearTimeout(this.stuck);
    if (this.pending.size === 0) return;
    this.stuck = setTimeout(() => {
      if (this.decoder.state !== "configured" || this.decoder.decodeQueueSize > 0) return;
      this.chained = false;
      this.decoder.flush().catch(() => undefined); // the `error` callback reports it
    }, stuckAfterMs);
  }

  private failed(why: Error): void {
    clearTimeout(this.stuck);
    this.chained = false;
    const waiting = [...this.pending.values()];
    this.pending.clear();
    for (const { reject } of waiting) reject(why);
  }
}
