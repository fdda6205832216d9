import { create } from "@bufbuild/protobuf";
import { beforeEach, describe, expect, it } from "vitest";
import { FrameSchema, ProblemSchema, StillSchema } from "../protocol/gen/api/proto/stream_pb";
import { Codec } from "../protocol/messages";
import { someScene } from "../scene/testing";
import { rgbOf } from "./lossless_assembler";
import { partDone, StillShot, type ShotState } from "./still_shot";
import { settled, WorkerByHand } from "./testing";

const size = { width: 32, height: 16 };

class World extends WorkerByHand<ShotState> {
  drawn: string[] = [];
  shot: StillShot;

  constructor(error: number) {
    super();
    this.shot = new StillShot(
      { scene: someScene(), size, error },
      {
        draw: (picture) => this.drawn.push(`${picture.width} x ${picture.height}`),
        drawTiles: (tiles) => this.drawn.push(`${tiles.length} tiles`),
      },
      {
        ...this.parts,
        decode: (frame) =>
          Promise.resolve({
            image: {} as CanvasImageSource,
            width: frame.width,
            height: frame.height,
            close: () => undefined,
          }),
        decodeStill: (still) =>
          Promise.resolve(new Uint8ClampedArray(4 * size.width * size.height).fill(still.data[0] ?? 0)),
        sha256: (bytes) => Promise.resolve(Uint8Array.of(bytes.reduce((a, b) => (a + b) % 251, 0))),
        stills: [],
        nowMs: () => 0,
      },
    );
  }
  async frame(error: number, more: object = {}): Promise<void> {
    this.say({
      case: "frame",
      value: create(FrameSchema, {
        codec: Codec.JPEG,
        seq: 1n,
        epoch: 2n,
        inputSeq: 2n,
        iteration: 64n,
        error,
        ...size,
        ...more,
      }),
    });
    await settled();
  }
}

let world: World;
beforeEach(async () => {
  world = new World(0.02);
  await world.live();
});

describe("an exported picture", () => {
  it("requests the given scene in its own size", () => {
    const hello = world.sent.find(({ body }) => body.case === "hello")?.body;
    expect(hello?.case === "hello" && hello.value.viewport).toMatchObject(size);
    const scene = world.sent.find(({ body }) => body.case === "scene")?.body;
    expect(scene?.case === "scene" && scene.value.scene?.lights.length).toBe(someScene().lights.length);
  });
  it("reports its progress, and uses the first frame that is good enough", async () => {
    await world.frame(0.04);
    expect(world.state).toEqual({ kind: "rendering", done: 0.25, waits: null });
    expect(world.drawn).toEqual([]);
    await world.frame(0.019);
    expect(world.state).toMatchObject({ kind: "done", error: 0.019, lossless: false });
    expect(world.drawn).toEqual(["32 x 16"]);
    expect(world.open).toBe(false);
    await world.frame(0.018);
    expect(world.drawn).toEqual(["32 x 16"]);
  });
  it("ignores frames of the session's initial scene or of another size", async () => {
    await world.frame(0.001, { inputSeq: 0n });
    await world.frame(0.001, { width: 16, height: 8 });
    expect(world.drawn).toEqual([]);
  });
  it("acknowledges every frame, so that more arrive", async () => {
    await world.frame(0.5);
    await world.frame(0.001, { width: 16 });
    expect(world.sent.filter(({ body }) => body.case === "ack")).toHaveLength(2);
  });
  it("ends when it is cancelled", () => {
    world.shot.stop();
    expect(world.state).toMatchObject({ kind: "failed", trouble: "stopped" });
    expect(world.open).toBe(false);
  });
  it("ends with the renderer's message if it refuses the scene", () => {
    world.say({ case: "problem", value: create(ProblemSchema, { message: "Too many lights." }) });
    expect(world.state).toEqual({ kind: "failed", trouble: "refused_scene", message: "Too many lights." });
  });
});

it("waits for its tiles if it is to be lossless", async () => {
  const exact = new World(0);
  await exact.live();
  await exact.frame(0.009);
  expect(exact.drawn).toEqual([]);
  const value = 7;
  const hash = Uint8Array.of(
    rgbOf(new Uint8ClampedArray(4 * size.width * size.height).fill(value)).reduce((a, b) => (a + b) % 251, 0),
  );
  exact.say({
    case: "still",
    value: create(StillSchema, {
      epoch: 2n,
      tiles: 1,
      ...size,
      data: Uint8Array.of(value),
      hash,
      iteration: 500n,
      error: 0.009,
    }),
  });
  await settled();
  expect(exact.drawn).toEqual(["1 tiles"]);
  expect(exact.state).toEqual({ kind: "done", samples: 500, error: 0.009, lossless: true });
});

it("reports that no rendering time is left, and ends", async () => {
  const spent = new World(0.02);
  spent.ticketSource = () => Promise.resolve({ ok: false, trouble: "time_spent", final: true });
  spent.shot.start();
  await settled();
  expect(spent.state).toEqual({ kind: "failed", trouble: "time_spent", message: "" });
});

it("reports that it waits for a free renderer", async () => {
  const busy = new World(0.02);
  busy.ticketSource = () => Promise.resolve({ ok: false, trouble: "no_worker", final: false });
  busy.shot.start();
  await settled();
  expect(busy.state).toEqual({ kind: "rendering", done: null, waits: "no_worker" });
});

it("measures its progress by the noise", () => {
  expect(partDone(0.04, 0.02)).toBe(0.25);
  expect(partDone(0.01, 0.02)).toBe(1);
  expect([partDone(Infinity, 0.02), partDone(NaN, 0.02), partDone(0, 0.02)]).toEqual([null, null, null]);
});
