import { describe, expect, it } from "vitest";
import type { Anonymise } from "../api/anonymise";
import { ApiProblem } from "../api/client";
import { carryOutCut } from "./carry_out";

const keep = { box: { low: [0, 0, 0], high: [1, 1, 1] } } as never;
const ready: Anonymise = { state: "ready", volume_hash: "a", anonymised_at: null, problem: null, head: null };

/** A server that answers a look with the first state that is left, and the last one again and again. */
function server(states: readonly (Anonymise | null)[], refusal: unknown = null) {
  const calls: string[] = [];
  const left = [...states];
  const api = {
    look: () => {
      calls.push("look");
      const state = left.length > 1 ? left.shift() : left[0];
      return state ? Promise.resolve(state) : Promise.reject(new ApiProblem(0, "offline", ""));
    },
    cut: () => {
      calls.push("cut");
      // eslint-disable-next-line @typescript-eslint/prefer-promise-reject-errors -- the reason is the test's
      return refusal === null ? Promise.resolve({ ...ready, state: "queued" as const }) : Promise.reject(refusal);
    },
  };
  const steps = { api, pause: () => Promise.resolve(), isOver: () => false };
  return { calls, run: () => carryOutCut(steps, "1", keep, "a") };
}

describe("a cut", () => {
  it("is asked about only once the server has it", async () => {
    const { calls, run } = server([ready, { ...ready, state: "queued" }, null, { ...ready, anonymised_at: "now" }]);
    expect(await run()).toBe("done");
    expect(calls).toEqual(["look", "cut", "look", "look", "look"]);
  });

  it("compares with the time of an earlier cut that this page did not know", async () => {
    const before = { ...ready, anonymised_at: "before" };
    expect(await server([before, { ...before, state: "building" }, { ...before, problem: "No." }]).run()).toEqual({
      problem: "No.",
    });
    expect(await server([before, { ...before, anonymised_at: "now" }]).run()).toBe("done");
  });

  it("does not report the failure of an earlier cut as its own", async () => {
    const failed = { ...ready, problem: "The disk is full." };
    expect(await server([failed, { ...ready, anonymised_at: "now" }]).run()).toBe("done");
    expect(await server([failed], new ApiProblem(0, "offline", "")).run()).toEqual({ problem: "" });
  });

  it("is followed if the answer to the request is lost", async () => {
    for (const lost of [new ApiProblem(0, "offline", ""), new ApiProblem(502, "internal", "")]) {
      const { run } = server([ready, null, { ...ready, state: "building" }, { ...ready, anonymised_at: "now" }], lost);
      expect(await run()).toBe("done");
    }
  });

  it("stops waiting once the scan is gone or the user is signed out", async () => {
    for (const kind of ["not-found", "unauthenticated"] as const) {
      const status = kind === "not-found" ? 404 : 401;
      let looks = 0;
      const look = () => (++looks === 1 ? Promise.resolve(ready) : Promise.reject(new ApiProblem(status, kind, "")));
      const api = { look, cut: () => Promise.resolve({ ...ready, state: "queued" as const }) };
      const steps = { api, pause: () => Promise.resolve(), isOver: () => looks > 3 };
      await expect(carryOutCut(steps, "1", keep, "a")).rejects.toMatchObject({ kind });
    }
  });

  it("throws if nothing was sent or the server refused", async () => {
    const offline = server([null]);
    await expect(offline.run()).rejects.toMatchObject({ kind: "offline" });
    expect(offline.calls).toEqual(["look"]);
    const refused = server([ready], new ApiProblem(409, "conflict", "The scan has changed."));
    await expect(refused.run()).rejects.toMatchObject({ status: 409 });
    expect(refused.calls).toEqual(["look", "cut"]);
  });
});
