import { create, fromBinary } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { DepthQueries, patienceMs, pauseMs, type Answered } from "./depth_queries";
import { ClientMessageSchema, DepthSchema } from "./gen/api/proto/stream_pb";

function atHand(live = true) {
  const sent: { id: bigint; x: number; y: number }[] = [];
  const timers = new Set<{ ms: number; task: () => void }>();
  const queries = new DepthQueries({
    send: (bytes) => {
      const { body } = fromBinary(ClientMessageSchema, bytes);
      if (body.case === "depthQuery") sent.push({ id: body.value.id, x: body.value.x, y: body.value.y });
      return live;
    },
    after: (ms, task) => {
      const timer = { ms, task };
      timers.add(timer);
      return () => timers.delete(timer);
    },
  });
  const pass = (ms: number) => {
    for (const timer of [...timers]) if (timer.ms === ms && timers.delete(timer)) timer.task();
  };
  return { queries, sent, timers, pass };
}
const answer = (id: bigint, distance: number | null) =>
  create(DepthSchema, { id, found: distance !== null, distance: distance ?? 0, place: { x: 1, y: 2, z: 3 } });
const none: Answered = { answered: false };

describe("depth queries", () => {
  it("are sent one after the other, with a pause that the renderer accepts", async () => {
    const { queries, sent, timers, pass } = atHand();
    const first = queries.ask(0.25, 0.5),
      second = queries.ask(1, 0);
    expect(sent).toEqual([{ id: 1n, x: 0.25, y: 0.5 }]);
    queries.receive(answer(9n, 1)); // nobody asked
    queries.receive(answer(1n, 480));
    expect(await first).toEqual({ answered: true, seen: { distance: 480, place: { x: 1, y: 2, z: 3 }, label: 0 } });
    expect(sent).toHaveLength(1);
    pass(pauseMs);
    expect(sent[1]).toEqual({ id: 2n, x: 1, y: 0 });
    queries.receive(answer(2n, null));
    expect(await second).toEqual({ answered: true, seen: null });
    pass(pauseMs);
    expect(timers.size).toBe(0);
  });

  it("end with the connection, without one, and after a timeout", async () => {
    expect(await atHand(false).queries.ask(0, 0)).toEqual(none);
    const one = atHand();
    const lost = [one.queries.ask(0, 0), one.queries.ask(1, 1)];
    one.queries.lost();
    expect(await Promise.all(lost)).toEqual([none, none]);
    one.pass(pauseMs);
    const late = one.queries.ask(0, 0);
    expect(one.sent).toHaveLength(2);
    one.pass(patienceMs);
    one.queries.receive(answer(2n, 5));
    expect(await late).toEqual(none);
  });
});
