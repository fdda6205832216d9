import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { FrameSchema } from "../protocol/gen/api/proto/stream_pb";
import type { Frame } from "../protocol/messages";
import { FramePipeline } from "./frame_pipeline";

const frame = (seq: number, epoch: number): Frame => create(FrameSchema, { seq: BigInt(seq), epoch: BigInt(epoch) });

class Bench {
  shown: number[] = [];
  acks = new Map<number, "dropped" | "decoded" | "shown">();
  closed = 0;
  private pending: { frame: Frame; done: (ok: boolean) => void }[] = [];
  readonly pipeline = new FramePipeline({
    decode: (f) =>
      new Promise<{ width: number; height: number; close: () => void }>((resolve, reject) => {
        this.pending.push({
          frame: f,
          done: (ok) => {
            if (ok) resolve({ width: 1, height: 1, close: () => (this.closed += 1) });
            else reject(new Error("damaged"));
          },
        });
      }),
    present: (_picture, f) => this.shown.push(Number(f.seq)),
    ack: (f, times) => {
      const seq = Number(f.seq);
      expect(this.acks.has(seq)).toBe(false);
      this.acks.set(seq, times.presented_ms !== undefined ? "shown" : times.decoded_ms !== undefined ? "decoded" : "dropped");
    },
    now_ms: () => 1,
  });
  async decoded(ok = true): Promise<void> {
    this.pending.shift()?.done(ok);
    await new Promise((resolve) => setTimeout(resolve, 0));
  }
}

describe("the way of a frame", () => {
  it("shows what comes, acknowledges each once and frees each picture", async () => {
    const bench = new Bench();
    for (const seq of [1, 2]) {
      bench.pipeline.receive(frame(seq, 1));
      await bench.decoded();
    }
    expect(bench.shown).toEqual([1, 2]);
    expect([...bench.acks.values()]).toEqual(["shown", "shown"]);
    expect(bench.closed).toBe(2);
  });

  it("a slow device shows the newest and skips what lies between", async () => {
    const bench = new Bench();
    for (const seq of [1, 2, 3, 4]) bench.pipeline.receive(frame(seq, 1));
    await bench.decoded();
    await bench.decoded();
    expect(bench.shown).toEqual([1, 4]);
    expect(bench.acks.get(2)).toBe("dropped");
    expect(bench.acks.get(3)).toBe("dropped");
  });

  it("never shows a frame of an older epoch, whether it comes late or was being decoded", async () => {
    const bench = new Bench();
    bench.pipeline.receive(frame(1, 1));
    bench.pipeline.receive(frame(2, 2));
    bench.pipeline.receive(frame(3, 1));
    await bench.decoded();
    await bench.decoded();
    expect(bench.shown).toEqual([2]);
    expect(bench.acks.get(1)).toBe("decoded");
    expect(bench.acks.get(3)).toBe("dropped");
  });

  it("a damaged frame is acknowledged and the next one shown", async () => {
    const bench = new Bench();
    bench.pipeline.receive(frame(1, 1));
    bench.pipeline.receive(frame(2, 1));
    await bench.decoded(false);
    await bench.decoded();
    expect(bench.shown).toEqual([2]);
    expect(bench.acks.get(1)).toBe("dropped");
  });

  it("after a reconnection epochs begin anew and nothing of before is shown", async () => {
    const bench = new Bench();
    bench.pipeline.receive(frame(9, 50));
    bench.pipeline.reset();
    bench.pipeline.receive(frame(1, 1));
    await bench.decoded();
    await bench.decoded();
    expect(bench.shown).toEqual([1]);
    expect(bench.acks.has(9)).toBe(false);
    expect(bench.closed).toBe(2);
  });
});
