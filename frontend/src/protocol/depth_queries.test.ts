import { create, fromBinary } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { DepthQueries, patienceMs, type Answered } from "./depth_queries";
import { ClientMessageSchema, DepthSchema } from "./gen/api/proto/stream_pb";

function atHand(live = true) {
  const sent: { id: bigint; x: number; y: number }[] = [];
  const timers = new Map<number, () => void>();
  let made = 0;
  const queries = new DepthQueries({
    send: (bytes) => {
      const { body } = fromBinary(ClientMessageSchema, bytes);
      if (body.case === "depthQuery") sent.push({ id: body.value.id, x: body.value.x, y: body.value.y });
      return live;
    },
    after: (ms, task) => {
      expect(ms).toBe(patienceMs);
      const id = ++made;
      timers.set(id, task);
      return () => timers.delete(id);
    },
  });
  return { queries, sent, timers };
}
const answer = (id: bigint, distance: number | null) =>
  create(DepthSchema, { id, found: distance !== null, distance: distance ?? 0, place: { x: 1, y: 2, z: 3 } });

describe("depth queries", () => {
  it("get their own answers in any order", async () => {
    const { queries, sent, timers } = atHand();
    const first = queries.ask(0.25, 0.5),
      second = queries.ask(1, 0);
    expect(sent).toEqual([
      { id: 1n, x: 0.25, y: 0.5 },
      { id: 2n, x: 1, y: 0 },
    ]);
    queries.receive(answer(2n, null));
    queries.receive(answer(1n, 480));
    queries.receive(answer(9n, 1)); // nobody asked
    expect(await first).toEqual({ answered: true, seen: { distance: 480, place: { x: 1, y: 2, z: 3 }, label: 0 } });
    expect(await second).toEqual({ answered: true, seen: null });
    expect(timers.size).toBe(0);
  });

  it("end with the connection, without one, and after a timeout", async () => {
    const none: Answered = { answered: false };
    expect(await atHand(false).queries.ask(0, 0)).toEqual(none);
    const one = atHand();
    const lost = one.queries.ask(0, 0);
    one.queries.lost();
    expect(await lost).toEqual(none);
    const late = one.queries.ask(0, 0);
    for (const task of one.timers.values()) task();
    one.queries.receive(answer(2n, 5));
    expect(await late).toEqual(none);
  });
});
