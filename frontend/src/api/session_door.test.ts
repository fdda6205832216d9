import { describe, expect, it } from "vitest";
import { ApiProblem } from "./client";
import { session_door, type SessionApi } from "./session_door";

const stream = (session_id: string) => ({ session_id, stream_url: `/stream?ticket=${session_id}` });
const never = new AbortController().signal;

function api(ticket: () => Promise<{ session_id: string; stream_url: string }>, created = () => Promise.resolve(stream("new"))) {
  const calls: string[] = [];
  const made: SessionApi = {
    create_ticket: (id) => {
      calls.push(`ticket ${id}`);
      return ticket();
    },
    create_session: () => {
      calls.push("session");
      return created();
    },
  };
  return { made, calls };
}
const fails = (status: number, kind: string, ms = 0) => () => Promise.reject(new ApiProblem(status, kind, "", [], ms));

describe("the door to a session", () => {
  it("goes back to the session that was there", async () => {
    const { made, calls } = api(() => Promise.resolve(stream("old")));
    expect(await session_door(made, "d", "old", () => undefined)(never)).toEqual({ ok: true, url: "/stream?ticket=old" });
    expect(calls).toEqual(["ticket old"]);
  });

  it("opens a new one where the old one is gone, says so, and goes back to that the next time", async () => {
    let gone = true;
    const { made, calls } = api(() => (gone ? fails(404, "not-found")() : Promise.resolve(stream("new"))));
    const told: string[] = [];
    const door = session_door(made, "d", "old", (id) => told.push(id));
    expect(await door(never)).toEqual({ ok: true, url: "/stream?ticket=new" });
    gone = false;
    await door(never);
    expect(calls).toEqual(["ticket old", "session", "ticket new"]);
    expect(told).toEqual(["new", "new"]);
  });

  it.each([
    [401, "unauthenticated", "signed_out", true],
    [404, "not-found", "not_found", true],
    [403, "render-time-spent", "time_spent", true],
    [409, "not-ready", "not_ready", false],
    [503, "no-worker", "no_worker", false],
    [503, "unavailable", "unreachable", false],
    [0, "offline", "unreachable", false],
  ])("%i %s is %s", async (status, kind, trouble, final) => {
    const { made } = api(fails(404, "not-found"), fails(status, kind, 2000));
    expect(await session_door(made, "d", null, () => undefined)(never)).toEqual({ ok: false, trouble, final, retry_after_ms: 2000 });
  });
});
