import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Codec } from "../protocol/messages";
import { H264Decoder } from "./h264";
import type { CodedPicture } from "./picture";

/** A VideoDecoder that gives pictures only when a test says so. */
class DecoderByHand {
  static made: DecoderByHand;
  state = "unconfigured";
  decodeQueueSize = 0;
  readonly codecs: string[] = [];
  readonly types: string[] = [];
  flushes = 0;

  constructor(private readonly callbacks: VideoDecoderInit) {
    DecoderByHand.made = this;
  }
  configure({ codec }: VideoDecoderConfig): void {
    this.state = "configured";
    this.codecs.push(codec);
  }
  decode({ type }: EncodedVideoChunkInit): void {
    this.types.push(type);
  }
  flush(): Promise<void> {
    this.flushes += 1;
    return Promise.resolve();
  }
  close(): void {
    this.state = "closed";
  }
  show(timestamp: number, close = vi.fn()): typeof close {
    this.callbacks.output({ timestamp, displayWidth: 32, displayHeight: 16, close } as unknown as VideoFrame);
    return close;
  }
  fail(): void {
    this.callbacks.error(new DOMException("broken"));
  }
}

class ChunkByHand {
  readonly type: string;
  constructor({ type }: EncodedVideoChunkInit) {
    this.type = type;
  }
}

const frame = (seq: number, key = false, decoder = "avc1.42"): CodedPicture => ({
  codec: Codec.H264,
  key,
  seq: BigInt(seq),
  data: new Uint8Array(1),
  decoder,
  width: 32,
  height: 16,
});

describe("the H.264 decoder", () => {
  let decoder: H264Decoder;

  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("VideoDecoder", DecoderByHand);
    vi.stubGlobal("EncodedVideoChunk", ChunkByHand);
    decoder = new H264Decoder();
  });
  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it("exists where the browser has WebCodecs", () => {
    expect(H264Decoder.exists()).toBe(true);
    vi.stubGlobal("VideoDecoder", undefined);
    expect(H264Decoder.exists()).toBe(false);
  });
  it("refuses a frame before the first key frame", async () => {
    await expect(decoder.decode(frame(1))).rejects.toThrow("refused");
    expect(DecoderByHand.made.types).toEqual([]);
  });
  it("is configured by key frames, once for the same codec", () => {
    const made = DecoderByHand.made;
    void decoder.decode(frame(1, true));
    void decoder.decode(frame(2));
    void decoder.decode(frame(3, true));
    void decoder.decode(frame(4, true, "avc1.64"));
    expect(made.codecs).toEqual(["avc1.42", "avc1.64"]);
    expect(made.types).toEqual(["key", "delta", "key", "key"]);
  });
  it("matches pictures with their frames, and closes any other", async () => {
    const [first, second] = [decoder.decode(frame(1, true)), decoder.decode(frame(2))];
    expect(DecoderByHand.made.show(7)).toHaveBeenCalledOnce();
    const close = [DecoderByHand.made.show(2), DecoderByHand.made.show(1)];
    expect(await first).toMatchObject({ width: 32, height: 16 });
    (await second).close();
    expect(close[0]).toHaveBeenCalledOnce();
    expect(close[1]).not.toHaveBeenCalled();
  });
  it("forces out a picture that is held back, after which it needs a key frame", async () => {
    const made = DecoderByHand.made;
    const held = decoder.decode(frame(1, true));
    vi.advanceTimersByTime(199);
    expect(made.flushes).toBe(0);
    vi.advanceTimersByTime(1);
    expect(made.flushes).toBe(1);
    made.show(1);
    await held;
    await expect(decoder.decode(frame(2))).rejects.toThrow("refused");
  });
  it("does not flush while frames are queued, or after the last picture", async () => {
    const made = DecoderByHand.made;
    made.decodeQueueSize = 1;
    const shown = decoder.decode(frame(1, true));
    vi.advanceTimersByTime(1000);
    made.decodeQueueSize = 0;
    made.show(1);
    await shown;
    vi.advanceTimersByTime(1000);
    expect(made.flushes).toBe(0);
  });
  it("rejects all that waits when it fails or is closed", async () => {
    const made = DecoderByHand.made;
    const waiting = [decoder.decode(frame(1, true)), decoder.decode(frame(2))];
    made.fail();
    for (const one of waiting) await expect(one).rejects.toThrow("broken");
    await expect(decoder.decode(frame(3))).rejects.toThrow("refused");
    const last = decoder.decode(frame(4, true));
    decoder.close();
    await expect(last).rejects.toThrow("closed");
    expect(made.state).toBe("closed");
  });
});
