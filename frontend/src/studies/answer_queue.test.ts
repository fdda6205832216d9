import { beforeEach, describe, expect, it } from "vitest";
import { ApiProblem } from "../api/client";
import { AnswerQueue, type Queued } from "./answer_queue";
import { failureOf } from "./participation";

class Store {
  readonly values = new Map<string, string>();
  getItem = (key: string) => this.values.get(key) ?? null;
  setItem = (key: string, value: string) => void this.values.set(key, value);
  removeItem = (key: string) => void this.values.delete(key);
}

let store: Store;
let server: Queued[];
let failing: unknown;
/** Holds the requests while it is pending. */
let gate: Promise<unknown>;
let waits: number[];
let timers: (() => void)[];

const open = () =>
  new AnswerQueue({
    store,
    key: "queue",
    send: async (item) => {
      await Promise.resolve();
      await gate;
      if (failing !== null) throw failing as Error;
      server.push(item);
    },
    failureOf,
    after: (ms, task) => {
      waits.push(ms);
      timers.push(task);
      return () => void (timers = timers.filter((one) => one !== task));
    },
  });
const settle = () => new Promise((resolve) => setTimeout(resolve, 0));
const fire = async () => {
  for (const task of timers.splice(0)) task();
  await settle();
};
const steps = () => server.map(({ step }) => step);

beforeEach(() => {
  store = new Store();
  server = [];
  failing = null;
  gate = Promise.resolve();
  waits = [];
  timers = [];
});

describe("the queue of answers", () => {
  it("sends answers in order with rising numbers, and forgets them once they are acknowledged", async () => {
    const queue = open();
    queue.answer("a", { rating: 1 }, 12.6);
    queue.answer("b", { words: "x" }, 5);
    await queue.whenEmpty();
    expect(server).toEqual([
      { kind: "answer", step: "a", value: { rating: 1 }, duration_ms: 13, sequence: 1 },
      { kind: "answer", step: "b", value: { words: "x" }, duration_ms: 5, sequence: 2 },
    ]);
    expect(open().pending.value).toEqual([]);
  });

  it.each([0, 408, 429, 500, 503])("repeats an answer after the status %i until the server has it", async (status) => {
    const queue = open();
    failing = new ApiProblem(status, "x", "");
    queue.answer("a", { rating: 1 }, 1);
    queue.answer("b", { rating: 2 }, 1);
    await settle();
    expect(queue.waiting.value).toBe(true);
    for (let i = 0; i < 6; ++i) await fire();
    expect(waits).toEqual([1000, 2000, 4000, 8000, 15_000, 15_000, 15_000]);
    expect(steps()).toEqual([]);
    failing = null;
    await fire();
    await settle();
    expect(steps()).toEqual(["a", "b"]);
    expect(queue.waiting.value).toBe(false);
  });

  it("continues after a reload with what is left, and with later numbers", async () => {
    const before = open();
    failing = new ApiProblem(0, "offline", "");
    before.answer("a", { rating: 1 }, 1);
    before.record("a", { events: [] });
    await settle();
    before.stop();
    failing = null;
    const queue = open();
    expect(queue.pending.value.map(({ kind }) => kind)).toEqual(["answer", "recording"]);
    queue.answer("b", { rating: 2 }, 1);
    await queue.whenEmpty();
    expect(steps()).toEqual(["a", "a", "b"]);
    expect(server.at(-1)).toMatchObject({ sequence: 2 });
  });

  it("does not overwrite the answers of the page that continues", async () => {
    let openGate: () => void = () => undefined;
    gate = new Promise<void>((resolve) => (openGate = resolve));
    const before = open();
    before.answer("a", { rating: 1 }, 1);
    await settle();
    before.stop(); // its request is still on the way
    gate = new Promise(() => undefined);
    const queue = open();
    queue.answer("b", { rating: 2 }, 1);
    openGate();
    await settle();
    expect(steps()).toEqual(["a"]);
    expect(open().pending.value.map(({ step }) => step)).toEqual(["a", "b"]);
  });

  it("skips an answer that the server refuses, and says which one", async () => {
    const queue = open();
    failing = new ApiProblem(400, "invalid", "");
    queue.answer("a", { rating: 99 }, 1);
    await settle();
    failing = null;
    queue.answer("b", { rating: 2 }, 1);
    await queue.whenEmpty();
    expect(queue.refused.value).toEqual(["a"]);
    expect(steps()).toEqual(["b"]);
  });

  it.each([
    ["study-closed", "over", ["a"]],
    ["participation-ended", "gone", []],
  ])("ends at the problem %s, and keeps what a study takes when it opens again", async (kind, why, left) => {
    const queue = open();
    failing = new ApiProblem(410, kind, "");
    queue.answer("a", { rating: 1 }, 1);
    await queue.whenEmpty();
    expect(queue.over.value).toBe(why);
    queue.answer("b", { rating: 1 }, 1);
    expect(open().pending.value.map(({ step }) => step)).toEqual(left);
  });

  it("starts empty when the stored text is damaged", () => {
    store.setItem("queue", "{broken");
    expect(open().pending.value).toEqual([]);
  });

  it("leaves nothing in the browser after a withdrawal", async () => {
    const queue = open();
    failing = new ApiProblem(0, "offline", "");
    queue.answer("a", { rating: 1 }, 1);
    await settle();
    queue.clear();
    await settle();
    expect([...store.values]).toEqual([]);
  });
});
