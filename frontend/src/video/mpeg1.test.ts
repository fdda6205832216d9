import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Codec } from "../protocol/messages";
import { Mpeg1Decoder } from "./mpeg1";
import type { Mpeg1Answer, Mpeg1Order } from "./mpeg1_worker";
import type { CodedPicture } from "./picture";

/** A worker that answers only when a test says so. */
class WorkerByHand {
  static made: WorkerByHand;
  onmessage: ((event: { data: Mpeg1Answer }) => void) | null = null;
  onerror: (() => void) | null = null;
  readonly orders: Mpeg1Order[] = [];
  ended = false;

  constructor() {
    WorkerByHand.made = this;
  }
  postMessage(order: Mpeg1Order): void {
    this.orders.push(order);
  }
  terminate(): void {
    this.ended = true;
  }
  answer(width: number | null): ReturnType<typeof vi.fn> {
    const close = vi.fn();
    this.onmessage?.({ data: width === null ? null : { width, height: 16, close } });
    return close;
  }
}

const frame = (key: boolean): CodedPicture => ({
  codec: Codec.MPEG1,
  key,
  seq: 1n,
  data: new Uint8Array(1),
  decoder: "",
  width: 32,
  height: 16,
});

describe("the MPEG-1 decoder", () => {
  let decoder: Mpeg1Decoder;

  beforeEach(() => {
    vi.stubGlobal("Worker", WorkerByHand);
    decoder = new Mpeg1Decoder();
  });
  afterEach(() => vi.unstubAllGlobals());

  it("refuses a frame before the first key frame, and then decodes a chain", async () => {
    await expect(decoder.decode(frame(false))).rejects.toThrow("without the key frame");
    const chain = [decoder.decode(frame(true)), decoder.decode(frame(false))];
    WorkerByHand.made.answer(32);
    WorkerByHand.made.answer(48);
    expect((await Promise.all(chain)).map((picture) => picture.width)).toEqual([32, 48]);
    expect(WorkerByHand.made.orders.map((order) => order.key)).toEqual([true, false]);
    expect(WorkerByHand.made.orders[0]).toMatchObject({ width: 32, height: 16 });
  });
  it("rejects a damaged frame", async () => {
    const damaged = decoder.decode(frame(true));
    WorkerByHand.made.answer(null);
    await expect(damaged).rejects.toThrow("damaged");
  });
  it("rejects all that waits when its worker fails, and then needs a key frame", async () => {
    const waiting = decoder.decode(frame(true));
    WorkerByHand.made.onerror?.();
    await expect(waiting).rejects.toThrow("could not be loaded");
    await expect(decoder.decode(frame(false))).rejects.toThrow("without the key frame");
  });
  it("ends its worker when it is closed, and closes a picture that comes too late", async () => {
    const waiting = decoder.decode(frame(true));
    decoder.close();
    await expect(waiting).rejects.toThrow("closed");
    expect(WorkerByHand.made.ended).toBe(true);
    expect(WorkerByHand.made.answer(32)).toHaveBeenCalledOnce();
  });
});
