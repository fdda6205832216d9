import { create } from "@bufbuild/protobuf";
import { createHash } from "node:crypto";
import { describe, expect, it } from "vitest";
import { StillSchema } from "../protocol/gen/api/proto/stream_pb";
import type { Still } from "../protocol/messages";
import { LosslessAssembler, rgbOf, type LosslessFacts, type TilePixels } from "./lossless_assembler";

const side = 2;
const pixels = (tile: number) =>
  Uint8ClampedArray.from({ length: 4 * side * side }, (_, n) => (n % 4 === 3 ? 255 : 10 * tile + n));
const sha256 = (bytes: Uint8Array) => new Uint8Array(createHash("sha256").update(bytes).digest());

/** Tile `tile` of a row of `tiles`. */
const still = (tile: number, tiles: number, epoch = 1, seq = tile + 1): Still =>
  create(StillSchema, {
    epoch: BigInt(epoch),
    tile,
    tiles,
    x: side * tile,
    y: 0,
    width: side,
    height: side,
    seq: BigInt(seq),
    iteration: 640n,
    error: 0.01,
    data: new Uint8Array([tile]),
    hash: sha256(rgbOf(pixels(tile))),
  });

class Bench {
  shown: { tiles: readonly TilePixels[]; facts: LosslessFacts }[] = [];
  damaged = 0;
  acks: number[] = [];
  fits = true;
  readonly end = new LosslessAssembler({
    decode: (one) => Promise.resolve(pixels(one.data[0] ?? 0)),
    sha256: (bytes) => Promise.resolve(sha256(bytes)),
    show: (tiles, facts) => {
      if (this.fits) this.shown.push({ tiles, facts });
      return this.fits;
    },
    damaged: () => (this.damaged += 1),
    ack: (one) => this.acks.push(Number(one.seq)),
    nowMs: () => 1,
  });
}

describe("the lossless picture", () => {
  it("appears at once when the last tile has arrived, in any order", async () => {
    const bench = new Bench();
    for (const tile of [2, 0]) await bench.end.receive(still(tile, 3));
    expect(bench.shown).toEqual([]);
    await bench.end.receive(still(1, 3));
    expect(bench.shown).toHaveLength(1);
    expect(bench.shown[0]?.facts).toEqual({ epoch: 1n, samples: 640, error: 0.01, width: 6, height: 2 });
    expect(new Set(bench.shown[0]?.tiles.map((tile) => tile.x))).toEqual(new Set([0, 2, 4]));
    expect(bench.end.shows(1n)).toBe(true);
    expect(bench.acks).toEqual([3, 1, 2]);
  });

  it("is not shown if a tile does not match its hash, which is reported once", async () => {
    const bench = new Bench();
    const wrong = still(1, 2);
    wrong.data = new Uint8Array([7]);
    await bench.end.receive(wrong);
    await bench.end.receive(still(0, 2));
    expect(bench.shown).toEqual([]);
    expect(bench.damaged).toBe(1);
    expect(bench.end.shows(1n)).toBe(false);
    expect(bench.acks).toHaveLength(2);
  });

  it("is refused if a single colour value differs", async () => {
    const bench = new Bench();
    const nearly = rgbOf(pixels(0));
    nearly[5] = (nearly[5] ?? 0) + 1;
    await bench.end.receive(create(StillSchema, { ...still(0, 1), hash: sha256(nearly) }));
    expect(bench.damaged).toBe(1);
  });

  it("is discarded by a newer epoch, also while tiles are being verified", async () => {
    const bench = new Bench();
    await bench.end.receive(still(0, 2));
    const late = bench.end.receive(still(1, 2));
    bench.end.epochIs(2n);
    await late;
    await bench.end.receive(still(1, 2, 1, 9));
    expect(bench.shown).toEqual([]);
    await bench.end.receive(still(0, 1, 2));
    expect(bench.shown.map(({ tiles }) => tiles.length)).toEqual([1]);
    expect(bench.end.shows(1n)).toBe(false);
    expect(bench.end.shows(2n)).toBe(true);
  });

  it("is refused if its tiles leave a gap or do not have the size of the canvas", async () => {
    const gap = new Bench();
    for (const tile of [0, 2]) await gap.end.receive(create(StillSchema, { ...still(tile, 2) }));
    expect(gap.shown).toEqual([]);
    const other = new Bench();
    other.fits = false;
    await other.end.receive(still(0, 1));
    expect(other.end.shows(1n)).toBe(false);
    expect(other.damaged).toBe(0);
  });

  it("restarts its epochs after a reconnection", async () => {
    const bench = new Bench();
    await bench.end.receive(still(0, 1, 50));
    bench.end.reset();
    expect(bench.end.shows(50n)).toBe(false);
    await bench.end.receive(still(0, 1, 3));
    expect(bench.shown).toHaveLength(2);
  });
});
