import { create, type MessageInitShape } from "@bufbuild/protobuf";
import { createHash } from "node:crypto";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { ErrorCurveSchema, FrameSchema, StillSchema } from "../protocol/gen/api/proto/stream_pb";
import { Codec, type Frame, type Still } from "../protocol/messages";
import { rgbOf } from "./lossless_assembler";
import { PictureStore } from "./picture_store";

// Node has no image decoders. A frame is decoded to its own size, and a tile to its own bytes.
vi.mock("./ladder", () => ({
  makeDecoder: () => ({
    independent: true,
    decode: ({ width, height }: Frame) => Promise.resolve({ image: null, width, height, close: () => undefined }),
    close: () => undefined,
  }),
}));
vi.mock("./tile_pixels", () => ({
  decodeStill: ({ data }: Still) => Promise.resolve(Uint8ClampedArray.from(data)),
}));

const settled = () => new Promise((resolve) => setTimeout(resolve, 0));
const frame = (
  seq: number,
  epoch = 1,
  more: Omit<MessageInitShape<typeof FrameSchema>, "$typeName" | "$unknown"> = {},
): Frame =>
  create(FrameSchema, {
    codec: Codec.JPEG,
    key: true,
    seq: BigInt(seq),
    epoch: BigInt(epoch),
    iteration: BigInt(10 * seq),
    error: 1 / seq,
    renderUs: BigInt(1_000_000 * seq),
    width: 2,
    height: 2,
    ...more,
  });
const pixels = Uint8ClampedArray.from({ length: 16 }, (_, n) => (n % 4 === 3 ? 255 : n));
const hash = new Uint8Array(createHash("sha256").update(rgbOf(pixels)).digest());
/** The only tile of a picture of 2 x 2 pixels. */
const tile = (epoch = 1, more: Omit<MessageInitShape<typeof StillSchema>, "$typeName" | "$unknown"> = {}): Still =>
  create(StillSchema, {
    epoch: BigInt(epoch),
    tile: 0,
    tiles: 1,
    width: 2,
    height: 2,
    seq: 100n,
    iteration: 640n,
    error: 0.01,
    data: new Uint8Array(pixels),
    hash,
    ...more,
  });

let painted: number[];
let exact: number;
let fits: boolean;
let acks: number[];
let damaged: number;
let store: PictureStore;

const show = async (...frames: Frame[]) => {
  for (const one of frames) {
    store.receive(one);
    await settled();
  }
};
const showLossless = async (still: Still) => {
  store.receiveStill(still);
  await vi.waitFor(() => expect(acks).toContain(Number(still.seq)));
};

it("shows no picture from before its first input, and all of them once that was refused", async () => {
  store.beginWith(2);
  await show(frame(1, 1, { inputSeq: 1n }), frame(2, 1, { inputSeq: 1n }));
  expect(store.picture.value).toBeNull();
  await show(frame(3, 2, { inputSeq: 2n }));
  expect(store.picture.value?.samples).toBe(30);
  store.beginWith(9);
  store.beginWith(0);
  await show(frame(4, 3, { inputSeq: 2n }));
  expect(store.picture.value?.samples).toBe(40);
});

it("shows the pictures of the next presenter, who has made fewer inputs", async () => {
  store.beginWith(2);
  await show(frame(1, 1, { inputSeq: 2n }), frame(2, 2, { inputSeq: 1n }));
  expect(store.picture.value?.samples).toBe(20);
});

beforeEach(() => {
  painted = [];
  exact = 0;
  fits = true;
  acks = [];
  damaged = 0;
  const painter = {
    paint: ({ width }: { readonly width: number }) => painted.push(width),
    paintExactly: () => {
      if (fits) exact += 1;
      return fits;
    },
    resize: () => undefined,
    png: () => Promise.resolve(null),
  };
  store = new PictureStore(painter, {
    ack: ({ seq }) => acks.push(Number(seq)),
    needKey: () => undefined,
    giveUp: () => undefined,
    damaged: () => (damaged += 1),
    nowMs: () => 1,
  });
});

describe("a streamed picture", () => {
  it("is painted, acknowledged and described", async () => {
    await show(frame(1, 3, { inputSeq: 7n, denoised: true, stops: -0.5, volumePhase: 6, width: 4, height: 2 }));
    expect(painted).toEqual([4]);
    expect(acks).toEqual([1]);
    expect(store.picture.value).toEqual({
      epoch: 3,
      inputSeq: 7,
      samples: 10,
      error: 1,
      seconds: 1,
      width: 4,
      height: 2,
      smoothed: true,
      stops: -0.5,
      phase: 6,
    });
  });

  it("adds a point to the curve of its epoch, and a new epoch starts a new curve", async () => {
    await show(frame(1), frame(2));
    expect(store.curve.value).toEqual([
      { samples: 10, seconds: 1, error: 1 },
      { samples: 20, seconds: 2, error: 0.5 },
    ]);
    await show(frame(3, 2));
    expect(store.curve.value).toHaveLength(1);
  });

  it("takes the worker's curve of its epoch, with passes that were never shown", async () => {
    await show(frame(1), frame(3));
    const point = (samples: bigint, seconds: number, error: number) => ({ samples, seconds, error });
    const points = [point(2n, 0.2, 0.9), point(10n, 1, 0.8), point(20n, 2, 0.5)];
    store.takeCurve(create(ErrorCurveSchema, { epoch: 2n, points }));
    expect(store.curve.value).toHaveLength(2);
    store.takeCurve(create(ErrorCurveSchema, { epoch: 1n, points }));
    expect(store.curve.value.map(({ samples }) => samples)).toEqual([2, 10, 20, 30]);
  });

  it("starts a new curve when the samples count from the beginning again", async () => {
    await show(frame(2));
    await show(frame(3, 1, { iteration: 1n }));
    expect(store.curve.value).toHaveLength(1);
  });

  it("may restart its epochs from one after a reset", async () => {
    await show(frame(9, 50));
    store.reset();
    await show(frame(1, 1));
    expect(store.picture.value?.epoch).toBe(1);
  });
});

describe("convergence", () => {
  it("holds for the epoch that is on the screen", async () => {
    await show(frame(1));
    store.setConverged(1);
    expect(store.converged.value).toBe(true);
    await show(frame(2, 2));
    expect(store.converged.value).toBe(false);
  });

  it("is known before the first picture of its epoch is on the screen", async () => {
    await show(frame(1));
    store.setConverged(2);
    expect(store.converged.value).toBe(false);
    await show(frame(2, 2));
    expect(store.converged.value).toBe(true);
  });

  it("ends when the server says that no epoch has converged, or with a new configuration", async () => {
    await show(frame(1));
    store.setConverged(1);
    store.setConverged(null);
    expect(store.converged.value).toBe(false);
    store.setConverged(1);
    store.reset();
    await show(frame(1));
    expect(store.converged.value).toBe(false);
  });
});

describe("the lossless picture", () => {
  it("replaces the streamed one, and its figures replace the streamed figures", async () => {
    await show(frame(1, 1, { denoised: true, inputSeq: 7n }));
    await showLossless(tile());
    expect(exact).toBe(1);
    expect(store.lossless.value).toMatchObject({ samples: 640, error: 0.01 });
    expect(store.picture.value).toMatchObject({ samples: 640, error: 0.01, smoothed: false, inputSeq: 7 });
  });

  it("is not covered by a late frame of the same epoch", async () => {
    await show(frame(1));
    await showLossless(tile());
    await show(frame(2));
    expect(painted).toHaveLength(1);
    expect(store.lossless.value).not.toBeNull();
    expect(acks).toContain(2);
  });

  it("gives way to a newer epoch", async () => {
    await show(frame(1));
    await showLossless(tile());
    await show(frame(2, 2));
    expect(painted).toHaveLength(2);
    expect(store.lossless.value).toBeNull();
  });

  it("of an older epoch is not shown while a newer frame is still being decoded", async () => {
    await show(frame(1));
    store.receive(frame(2, 2));
    await showLossless(tile());
    expect(exact).toBe(0);
  });

  it("is no longer exact once the canvas has another size", async () => {
    await show(frame(1));
    await showLossless(tile());
    store.resize({ width: 8, height: 8 });
    expect(store.lossless.value).toBeNull();
  });

  it("is not claimed if it does not fit the canvas", async () => {
    fits = false;
    await show(frame(1));
    await showLossless(tile());
    expect(store.lossless.value).toBeNull();
    expect(store.picture.value?.samples).toBe(10);
  });

  it("is replaced by the streamed picture if a tile is damaged, which is reported", async () => {
    await show(frame(1));
    await showLossless(tile(1, { hash: new Uint8Array(32) }));
    expect(damaged).toBe(1);
    expect(exact).toBe(0);
    expect(store.lossless.value).toBeNull();
  });
});
