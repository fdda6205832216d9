import { describe, expect, it } from "vitest";
import { ApiProblem } from "./client";
import { guestTicketSource, sessionTicketSource, visitTicketSource, type SessionApi } from "./ticket_source";

const stream = (sessionId: string) => ({ session_id: sessionId, stream_url: `/stream?ticket=${sessionId}` });
const never = new AbortController().signal;

function api(
  ticket: () => Promise<{ session_id: string; stream_url: string }>,
  created = () => Promise.resolve(stream("new")),
) {
  const calls: string[] = [];
  const made: SessionApi = {
    createTicket: (id) => {
      calls.push(`ticket ${id}`);
      return ticket();
    },
    createSession: () => {
      calls.push("session");
      return created();
    },
  };
  return { made, calls };
}
const fails =
  (status: number, kind: string, ms = 0) =>
  () =>
    Promise.reject(new ApiProblem(status, kind, "", [], ms));

describe("the ticket source of a session", () => {
  it("returns to the existing session", async () => {
    const { made, calls } = api(() => Promise.resolve(stream("old")));
    expect(await sessionTicketSource(made, "d", "old", () => undefined)(never)).toEqual({
      ok: true,
      url: "/stream?ticket=old",
    });
    expect(calls).toEqual(["ticket old"]);
  });

  it("opens and reports a new session if the old one is gone, and returns to it later", async () => {
    let gone = true;
    const { made, calls } = api(() => (gone ? fails(404, "not-found")() : Promise.resolve(stream("new"))));
    const told: string[] = [];
    const ticketSource = sessionTicketSource(made, "d", "old", (id) => told.push(id));
    expect(await ticketSource(never)).toEqual({ ok: true, url: "/stream?ticket=new" });
    gone = false;
    await ticketSource(never);
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
    expect(await sessionTicketSource(made, "d", null, () => undefined)(never)).toEqual({
      ok: false,
      trouble,
      final,
      retryAfterMs: 2000,
    });
  });
});

describe("the ticket source of a guest", () => {
  it.each([
    [404, "not-found", "link_ended", true],
    [503, "busy", "guests_full", false],
    [503, "no-worker", "no_worker", false],
  ])("%i %s is %s", async (status, kind, trouble, final) => {
    const refused = fails(status, kind, 2000);
    const visit = visitTicketSource({ visit: refused }, { token: "t" }, "k");
    const join = guestTicketSource({ join: refused }, "t", "k", "Anna");
    const answer = { ok: false, trouble, final, retryAfterMs: 2000 };
    expect([await visit(never), await join(never)]).toEqual([answer, answer]);
  });
});
