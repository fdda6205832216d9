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
  it("gets a ticket, opens, sends a greeting and is live", () => {
    expect(run(toLive.slice(0, 1)).effects).toEqual(["ask_ticket", "timer"]);
    expect(run(toLive.slice(0, 2)).effects).toEqual(["open", "timer"]);
    expect(run(toLive.slice(0, 3)).effects).toEqual(["greet", "timer"]);
    expect(run(toLive)).toEqual({
      state: { phase: "live", attempt: 0, wasLive: true, trouble: null },
      effects: ["disarm"],
    });
  });

  it("reconnects after any close, always with a new ticket", () => {
    for (const code of [1000, 1001, 1006, 4401, 4404, 4503, 4429, 4400]) {
      const lost = run([...toLive, { kind: "closed", code }]);
      expect(lost.state.phase).toBe("waiting");
      expect(lost.state.trouble).not.toBeNull();
      expect(run([{ kind: "timeout" }], lost.state).effects).toEqual(["ask_ticket", "timer"]);
    }
  });

  it("says what the codes of the contract mean", () => {
    const troubles = {
      4400: "refused",
      1009: "refused",
      4429: "no_worker",
      4503: "worker_lost",
      4404: "lost",
      1000: "lost",
    };
    for (const [code, trouble] of Object.entries(troubles))
      expect(run([...toLive, { kind: "closed", code: Number(code) }]).state.trouble).toBe(trouble);
  });

  it("treats a server that can't be reached like a closed connection, but only while it is live", () => {
    const lost = run([...toLive, { kind: "lost" }]);
    expect(lost.effects).toEqual(["close", "timer"]);
    expect(lost.state).toMatchObject({ phase: "waiting", trouble: "lost" });
    expect(run([...toLive.slice(0, 2), { kind: "lost" }]).state.phase).toBe("opening");
  });

  it("greets again over another connection at once when the page asks for it", () => {
    const again = run([...toLive, { kind: "again" }]);
    expect(again.effects).toEqual(["close", "ask_ticket", "timer"]);
    expect(again.state).toMatchObject({ phase: "asking", attempt: 0, trouble: null });
    expect(run([...toLive.slice(0, 2), { kind: "again" }]).state.phase).toBe("opening"); // it is still to greet
  });

  it("leaves a session to another window until the user wants to continue here", () => {
    const taken = run([...toLive, { kind: "closed", code: 4409 }]);
    expect(taken.state).toMatchObject({ phase: "elsewhere", trouble: "taken_over" });
    expect(run([{ kind: "timeout" }, { kind: "wake" }], taken.state).effects).toEqual([]);
    expect(run([{ kind: "start" }], taken.state)).toMatchObject({ state: { phase: "asking", trouble: null } });
  });

  it("does not reconnect after being displaced by a user with an account", () => {
    const gone = run([...toLive, { kind: "closed", code: 4411 }]);
    expect(gone.state).toMatchObject({ phase: "stopped", trouble: "displaced" });
    expect(run([{ kind: "timeout" }, { kind: "wake" }], gone.state).effects).toEqual([]);
  });

  it("waits longer after each attempt, and resets only after a picture", () => {
    let state = run(toLive).state;
    for (let i = 1; i <= 4; i++) {
      state = run([{ kind: "closed", code: 4503 }, { kind: "timeout" }, ...toLive.slice(1)], state).state;
      expect(state.attempt).toBe(i);
    }
    expect(run([{ kind: "picture" }], state).state.attempt).toBe(0);
  });

  it("reconnects within five seconds to a worker that needs three to restart", () => {
    let waited = 0;
    let tries = 0;
    while (waited < 3000) waited += waitMs(tries++, 0.99);
    expect(waited).toBeLessThan(5000);
  });

  it("stops after a final close, and does nothing afterwards", () => {
    const stopped = run([{ kind: "start" }, { kind: "no_ticket", trouble: "not_found", final: true }]);
    expect(stopped.state).toMatchObject({ phase: "stopped", trouble: "not_found" });
    expect(run([{ kind: "wake" }, { kind: "timeout" }, { kind: "start" }], stopped.state).state).toEqual(stopped.state);
  });

  it("treats a slow step as failed, and ends a wait when the network is back", () => {
    for (let steps = 1; steps <= 3; steps++)
      expect(run([...toLive.slice(0, steps), { kind: "timeout" }]).state.phase).toBe("waiting");
    const waiting = run([...toLive, { kind: "closed", code: 1006 }]).state;
    expect(run([{ kind: "wake" }], waiting).state.phase).toBe("asking");
  });

  it("ignores a late answer to an earlier step", () => {
    const waiting = run([...toLive, { kind: "closed", code: 1006 }]).state;
    for (const late of [...toLive.slice(1), { kind: "closed", code: 1006 } as const])
      expect(run([late], waiting).state).toEqual(waiting);
  });

  it("follows Retry-After within limits and spreads the attempts", () => {
    expect(waitMs(0, 0.5, 3000)).toBe(3000);
    expect(waitMs(0, 0.5, 3_600_000)).toBe(5000);
    expect(waitMs(3, 0)).toBeLessThan(waitMs(3, 0.99));
  });
});
