import { describe, expect, it } from "vitest";
import { inflate, valuesOf } from "./coding";
import { SliceStore, mostBytes, type Coming, type SliceId } from "./store";

/** As the server does it: low and high bytes apart. */
function coded(values: readonly number[]): Uint8Array<ArrayBuffer> {
  return new Uint8Array([...values.map((value) => value & 255), ...values.map((value) => (value >> 8) & 255)]);
}

function world(inflated = (data: Uint8Array<ArrayBuffer>) => Promise.resolve(data)) {
  const asked: { lacking: readonly SliceId[]; taken: bigint }[] = [];
  const received: SliceId[] = [];
  let damaged = 0;
  let frames: (() => void)[] = [];
  const store = new SliceStore({
    ask: (lacking, taken) => asked.push({ lacking, taken }),
    inflate: inflated,
    nextFrame: (task) => frames.push(task),
    received: (slice) => received.push(slice),
    damaged: () => (damaged += 1),
  });
  const frame = () => {
    const due = frames;
    frames = [];
    for (const task of due) task();
  };
  return { store, asked, received, frame, damaged: () => damaged };
}
const coming = (seq: number, index: number, more: Partial<Coming> = {}): Coming => ({
  seq: BigInt(seq),
  plane: "axial",
  index,
  columns: 2,
  rows: 2,
  data: coded([1, -2, 32767, -32768]),
  ...more,
});

describe("a slice's bytes", () => {
  it("are decoded to the original values", async () => {
    const values = [-32768, 32767, 0, 5, -1, 300];
    expect([...valuesOf(coded(values), 3, 2)]).toEqual(values);
    const zipped = new Blob([coded(values)]).stream().pipeThrough(new CompressionStream("deflate"));
    const data = new Uint8Array(await new Response(zipped).arrayBuffer());
    expect([...valuesOf(await inflate(data), 3, 2)]).toEqual(values);
  });
  it("are invalid if they have another size", () => {
    expect(() => valuesOf(new Uint8Array(7), 2, 2)).toThrow();
  });
});

describe("the slice store", () => {
  it("requests only the newest slice once per screen refresh, and acknowledges it", async () => {
    const { store, asked, received, frame } = world();
    for (const index of [1, 2, 3]) store.show("axial", index);
    store.show("coronal", 7);
    frame();
    expect(asked).toEqual([
      {
        lacking: [
          { plane: "axial", index: 3 },
          { plane: "coronal", index: 7 },
        ],
        taken: 0n,
      },
    ]);
    await store.receive(coming(1, 3));
    expect(received).toEqual([{ plane: "axial", index: 3 }]);
    expect([...(store.get({ plane: "axial", index: 3 })?.values ?? [])]).toEqual([1, -2, 32767, -32768]);
    frame();
    expect(asked[1]).toEqual({ lacking: [{ plane: "coronal", index: 7 }], taken: 1n });
  });
  it("keeps the labels of a slice, and none of a slice without them", async () => {
    const { store, damaged } = world();
    await store.receive(coming(1, 3, { labels: new Uint8Array([0, 2, 255, 1]) }));
    expect([...(store.get({ plane: "axial", index: 3 })?.labels ?? [])]).toEqual([0, 2, 255, 1]);
    await store.receive(coming(2, 4));
    expect(store.get({ plane: "axial", index: 4 })?.labels).toBeNull();
    await store.receive(coming(3, 5, { labels: new Uint8Array(3) }));
    expect(damaged()).toBe(1);
  });
  it("keeps the values of the second scan, and none of a session with one scan", async () => {
    const { store, damaged } = world();
    await store.receive(coming(1, 3, { second: new Uint8Array([5, 6, 7, 8, 0, 0, 0, 128]) }));
    expect([...(store.get({ plane: "axial", index: 3 })?.second ?? [])]).toEqual([5, 6, 7, -32760]);
    await store.receive(coming(2, 4));
    expect(store.get({ plane: "axial", index: 4 })?.second).toBeNull();
    await store.receive(coming(3, 5, { second: new Uint8Array(4) }));
    expect(damaged()).toBe(1);
  });
  it("does not request cached slices again", async () => {
    const { store, asked, frame } = world();
    store.show("axial", 3);
    frame();
    await store.receive(coming(1, 3));
    frame();
    store.show("axial", 4);
    store.show("axial", 3);
    frame();
    expect(asked.at(-1)?.lacking).toEqual([]);
  });
  it("requests slices again after a lost connection, and drops those of the old one", async () => {
    let go: (data: Uint8Array<ArrayBuffer>) => void = () => undefined;
    const { store, asked, received, frame } = world(() => new Promise((resolve) => (go = resolve)));
    store.show("axial", 3);
    frame();
    const reading = store.receive(coming(9, 3));
    store.connected();
    go(coded([0, 0, 0, 0]));
    await reading;
    expect(received).toEqual([]);
    frame();
    expect(asked.at(-1)).toEqual({ lacking: [{ plane: "axial", index: 3 }], taken: 0n });
  });
  it("reports a damaged slice and does not request it endlessly", async () => {
    const { store, asked, frame, damaged } = world();
    store.show("axial", 3);
    frame();
    await store.receive(coming(1, 3, { data: new Uint8Array(3) }));
    frame();
    expect(damaged()).toBe(1);
    expect(asked.at(-1)?.lacking).toEqual([]);
  });
  it("limits its cache and keeps the visible slices", async () => {
    const { store } = world(() => Promise.resolve(new Uint8Array(mostBytes / 2)));
    store.show("axial", 0);
    const half = { columns: mostBytes / 4, rows: 1 };
    for (const index of [0, 1, 2]) await store.receive(coming(index + 1, index, half));
    expect([0, 1, 2].map((index) => store.get({ plane: "axial", index }) !== null)).toEqual([true, false, true]);
  });
});
