import { describe, expect, it } from "vitest";
import { advance, firstState, waitMs, type ConnectionEvent, type ConnectionState } from "./connection";

function run(events: ConnectionEvent[], from: ConnectionState = firstState) {
  let state = from;
  let effects: string[] = [];
  for (const event of events) {
    const step = advance(state, event, 0.5);
    state = step.state;
    effects = step.effects.map((effect) => effect.kind);
  }
  return { state, effects };
}

const toLive: ConnectionEvent[] = [
  { kind: "start" },
  { kind: "ticket", url: "/stream?ticket=1" },
  { kind: "opened" },
  { kind: "configured" },
];

describe("the connection", () => {
  it("asks for a ticket, opens, greets and lives", () => {
    expect(run(toLive.slice(0, 1)).effects).toEqual(["ask_ticket", "timer"]);
    expect(run(toLive.slice(0, 2)).effects).toEqual(["open", "timer"]);
    expect(run(toLive.slice(0, 3)).effects).toEqual(["greet", "timer"]);
    expect(run(toLive)).toEqual({
      state: { phase: "live", attempt: 0, wasLive: true, trouble: null },
      effects: ["disarm"],
    });
  });

  it("comes back by itself after any close, always with a new ticket", () => {
    for (const code of [1000, 1001, 1006, 4401, 4404, 4503, 4429, 4400]) {
      const lost = run([...toLive, { kind: "closed", code }]);
      expect(lost.state.phase).toBe("waiting");
      expect(lost.state.trouble).not.toBeNull();
      expect(run([{ kind: "timeout" }], lost.state).effects).toEqual(["ask_ticket", "timer"]);
    }
  });

  it("greets again over another connection at once when the page asks for it", () => {
    const again = run([...toLive, { kind: "again" }]);
    expect(again.effects).toEqual(["close", "ask_ticket", "timer"]);
    expect(again.state).toMatchObject({ phase: "asking", attempt: 0, trouble: null });
    expect(run([...toLive.slice(0, 2), { kind: "again" }]).state.phase).toBe("opening"); // it is still to greet
  });

  it("leaves a session that another window took over alone until asked to continue here", () => {
    const taken = run([...toLive, { kind: "closed", code: 4409 }]);
    expect(taken.state).toMatchObject({ phase: "elsewhere", trouble: "taken_over" });
    expect(run([{ kind: "timeout" }, { kind: "wake" }], taken.state).effects).toEqual([]);
    expect(run([{ kind: "start" }], taken.state)).toMatchObject({ state: { phase: "asking", trouble: null } });
  });

  it("does not come back by itself to a place that somebody with an account needs", () => {
    const gone = run([...toLive, { kind: "closed", code: 4411 }]);
    expect(gone.state).toMatchObject({ phase: "stopped", trouble: "displaced" });
    expect(run([{ kind: "timeout" }, { kind: "wake" }], gone.state).effects).toEqual([]);
  });

  it("waits longer after each try, and resets only after a picture", () => {
    let state = run(toLive).state;
    for (let i = 1; i <= 4; i++) {
      state = run([{ kind: "closed", code: 4503 }, { kind: "timeout" }, ...toLive.slice(1)], state).state;
      expect(state.attempt).toBe(i);
    }
    expect(run([{ kind: "picture" }], state).state.attempt).toBe(0);
  });

  it("is back within five seconds of a worker that needs three to come back", () => {
    let waited = 0;
    let tries = 0;
    while (waited < 3000) waited += waitMs(tries++, 0.99);
    expect(waited).toBeLessThan(5000);
  });

  it("stops where trying again is no use, and does nothing afterwards", () => {
    const stopped = run([{ kind: "start" }, { kind: "no_ticket", trouble: "not_found", final: true }]);
    expect(stopped.state).toMatchObject({ phase: "stopped", trouble: "not_found" });
    expect(run([{ kind: "wake" }, { kind: "timeout" }, { kind: "start" }], stopped.state).state).toEqual(stopped.state);
  });

  it("a step that takes too long is a failed try; a wait ends at once when the network is back", () => {
    for (let steps = 1; steps <= 3; steps++)
      expect(run([...toLive.slice(0, steps), { kind: "timeout" }]).state.phase).toBe("waiting");
    const waiting = run([...toLive, { kind: "closed", code: 1006 }]).state;
    expect(run([{ kind: "wake" }], waiting).state.phase).toBe("asking");
  });

  it("a late answer to an earlier step changes nothing", () => {
    const waiting = run([...toLive, { kind: "closed", code: 1006 }]).state;
    for (const late of [...toLive.slice(1), { kind: "closed", code: 1006 } as const])
      expect(run([late], waiting).state).toEqual(waiting);
  });

  it("honours Retry-After within reason and spreads the tries", () => {
    expect(waitMs(0, 0.5, 3000)).toBe(3000);
    expect(waitMs(0, 0.5, 3_600_000)).toBe(5000);
    expect(waitMs(3, 0)).toBeLessThan(waitMs(3, 0.99));
  });
});
