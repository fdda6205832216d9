import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { FrameSchema } from "../protocol/gen/api/proto/stream_pb";
import { Codec, type Frame } from "../protocol/messages";
import { forgottenAfter, FramePipeline, longestQueue, mostFailures } from "./frame_pipeline";

const jpeg = (seq: number, epoch = 1): Frame =>
  create(FrameSchema, { codec: Codec.JPEG, key: true, seq: BigInt(seq), epoch: BigInt(epoch) });
const h264 = (seq: number, epoch = 1, key = seq === 1): Frame =>
  create(FrameSchema, { codec: Codec.H264, key, seq: BigInt(seq), epoch: BigInt(epoch) });

/** Decoders by hand: a frame is decoded when the test says so. */
class Bench {
  shown: number[] = [];
  acks = new Map<number, "dropped" | "decoded" | "shown">();
  queues: number[] = [];
  closed = 0;
  keysAsked = 0;
  givenUp: Codec[] = [];
  made = 0;
  fed: number[] = [];
  private pending: { resolve: (picture: { close: () => void }) => void; reject: (why: Error) => void }[] = [];
  readonly pipeline = new FramePipeline({
    makeDecoder: (codec) => {
      if (codec === Codec.MPEG1) return null;
      this.made += 1;
      const own = new Set<(why: Error) => void>();
      return {
        independent: codec === Codec.JPEG,
        decode: (frame) =>
          new Promise<{ close: () => void }>((resolve, reject) => {
            this.fed.push(Number(frame.seq));
            this.pending.push({ resolve, reject });
            own.add(reject);
          }),
        close: () => {
          for (const reject of own) reject(new Error("closed"));
        },
      };
    },
    present: (_picture, f) => this.shown.push(Number(f.seq)),
    ack: (f, times, queue) => {
      const seq = Number(f.seq);
      expect(this.acks.has(seq)).toBe(false);
      this.acks.set(
        seq,
        times.presentedMs !== undefined ? "shown" : times.decodedMs !== undefined ? "decoded" : "dropped",
      );
      this.queues.push(queue);
    },
    needKey: () => (this.keysAsked += 1),
    giveUp: (codec) => this.givenUp.push(codec),
    nowMs: () => 1,
  });

  async decoded(ok = true): Promise<void> {
    const next = this.pending.shift();
    if (ok) next?.resolve({ close: () => (this.closed += 1) });
    else next?.reject(new Error("damaged"));
    await this.rest();
  }
  async rest(): Promise<void> {
    await new Promise((resolve) => setTimeout(resolve, 0));
  }
  async given(frame: Frame, ok = true): Promise<void> {
    this.pipeline.receive(frame);
    await this.decoded(ok);
  }
}

describe("an independent frame", () => {
  it("is shown, acknowledged once and released", async () => {
    const bench = new Bench();
    for (const seq of [1, 2]) await bench.given(jpeg(seq));
    expect(bench.shown).toEqual([1, 2]);
    expect([...bench.acks.values()]).toEqual(["shown", "shown"]);
    expect(bench.closed).toBe(2);
  });

  it("waits only if it is the newest, while another is decoded", async () => {
    const bench = new Bench();
    for (const seq of [1, 2, 3, 4]) bench.pipeline.receive(jpeg(seq));
    await bench.decoded();
    await bench.decoded();
    expect(bench.shown).toEqual([1, 4]);
    expect(bench.acks.get(2)).toBe("dropped");
    expect(bench.acks.size).toBe(4);
  });

  it("is never shown after one of a newer epoch", async () => {
    const bench = new Bench();
    await bench.given(jpeg(1, 2));
    await bench.given(jpeg(2, 1));
    expect(bench.shown).toEqual([1]);
    expect(bench.acks.get(2)).toBe("decoded");
  });

  it("is shown even if newer ones arrive faster than they can be decoded", async () => {
    const bench = new Bench();
    bench.pipeline.receive(jpeg(1, 1));
    for (let seq = 2; seq < 8; seq++) {
      bench.pipeline.receive(jpeg(seq, seq)); // each answers a newer input
      await bench.decoded();
    }
    expect(bench.shown).toEqual([1, 2, 3, 4, 5, 6]);
  });

  it("is replaced by the next one if it is damaged", async () => {
    const bench = new Bench();
    bench.pipeline.receive(jpeg(1));
    bench.pipeline.receive(jpeg(2));
    await bench.decoded(false);
    await bench.decoded();
    expect(bench.shown).toEqual([2]);
    expect(bench.acks.get(1)).toBe("dropped");
    expect(bench.keysAsked).toBe(0);
  });

  it("is not shown after a reconnection if it is older, because epochs restart", async () => {
    const bench = new Bench();
    bench.pipeline.receive(jpeg(9, 50));
    bench.pipeline.reset();
    bench.pipeline.receive(jpeg(1, 1));
    await bench.decoded();
    await bench.decoded();
    expect(bench.shown).toEqual([1]);
    expect(bench.acks.has(9)).toBe(false);
  });
});

describe("a chained frame", () => {
  it("always reaches the decoder, whatever else waits", async () => {
    const bench = new Bench();
    for (const seq of [1, 2, 3]) bench.pipeline.receive(h264(seq, seq));
    expect(bench.fed).toEqual([1, 2, 3]);
    for (let n = 0; n < 3; n++) await bench.decoded();
    expect(bench.acks.size).toBe(3);
    expect(bench.queues).toEqual([2, 1, 0]);
  });

  it("is skipped up to the next key frame, requested once, if the queue grows too long", async () => {
    const bench = new Bench();
    for (let seq = 1; seq <= longestQueue + 3; seq++) bench.pipeline.receive(h264(seq));
    await bench.rest();
    expect(bench.keysAsked).toBe(1);
    expect(bench.fed).toEqual([1, 2, 3]);
    expect([...bench.acks.values()].every((how) => how === "dropped")).toBe(true);
    expect(bench.acks.size).toBe(longestQueue + 3);
    bench.pipeline.receive(h264(7, 1, true));
    bench.pipeline.receive(h264(8));
    expect(bench.fed).toEqual([1, 2, 3, 7, 8]);
    expect(bench.made).toBe(2);
  });

  it("gets a new decoder after a failure, starting with a key frame", async () => {
    const bench = new Bench();
    await bench.given(h264(1));
    await bench.given(h264(2), false);
    expect(bench.keysAsked).toBe(1);
    bench.pipeline.receive(h264(3));
    expect(bench.fed).toEqual([1, 2]);
    await bench.given(h264(4, 1, true));
    expect(bench.shown).toEqual([1, 4]);
    expect(bench.made).toBeGreaterThan(1);
    expect(bench.givenUp).toEqual([]);
  });

  it("abandons its codec after three failures in a row", async () => {
    const bench = new Bench();
    for (let n = 1; n <= mostFailures; n++) {
      expect(bench.givenUp).toEqual([]);
      await bench.given(h264(2 * n, 1, true)); // the key frames do not hide that all others fail
      await bench.given(h264(2 * n + 1), false);
    }
    expect(bench.givenUp).toEqual([Codec.H264]);
  });

  it("may fail occasionally", async () => {
    const bench = new Bench();
    for (let n = 0, seq = 1; n < 2 * mostFailures; n++) {
      for (let m = 0; m < forgottenAfter; m++) await bench.given(h264(seq++, 1, m === 0));
      await bench.given(h264(seq++), false);
    }
    expect(bench.givenUp).toEqual([]);
  });

  it("abandons an unknown codec as well", () => {
    const bench = new Bench();
    for (let seq = 1; seq <= mostFailures; seq++)
      bench.pipeline.receive(create(FrameSchema, { codec: Codec.MPEG1, seq: BigInt(seq) }));
    expect(bench.givenUp).toEqual([Codec.MPEG1]);
    expect(bench.acks.size).toBe(mostFailures);
  });
});
