import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { ApiProblem } from "../api/client";
import { guestTicketSource, studyTicketSource } from "../api/ticket_source";
import { AudienceSchema } from "../protocol/gen/api/proto/stream_pb";
import { newGuest, rememberedGuest } from "./place";
import { roleOf } from "./role";

const token = "a".repeat(64);

function store(): Pick<Storage, "getItem" | "setItem"> {
  const kept = new Map<string, string>();
  return { getItem: (key) => kept.get(key) ?? null, setItem: (key, value) => void kept.set(key, value) };
}

describe("a guest", () => {
  it("is the same after a reload, and another one for another link", () => {
    const here = store();
    const guest = newGuest(here, token, "  Ann  ");
    expect(guest).toMatchObject({ name: "Ann" });
    expect(guest.key).toMatch(/^[0-9a-f]{64}$/);
    expect(rememberedGuest(here, token)).toEqual(guest);
    expect(rememberedGuest(here, "b".repeat(64))).toBeNull();
    here.setItem(`diaphane.guest.${token.slice(0, 8)}`, "{broken");
    expect(rememberedGuest(here, token)).toBeNull();
  });

  it("learns that a link was disabled, and retries after every other error", async () => {
    const signal = new AbortController().signal;
    const refused = (status: number, kind: string) =>
      guestTicketSource({ join: () => Promise.reject(new ApiProblem(status, kind, "")) }, token, "k", "Ann")(signal);
    expect(await refused(404, "not-found")).toMatchObject({ ok: false, trouble: "link_ended", final: true });
    expect(await refused(503, "no-worker")).toMatchObject({ ok: false, trouble: "no_worker", final: false });
    const joined = guestTicketSource(
      { join: (at, key, name) => Promise.resolve({ stream_url: [at, key, name].join() }) },
      token,
      "k",
      "Ann",
    );
    expect(await joined(signal)).toEqual({ ok: true, url: `${token},k,Ann` });
  });
});

it("a participant's picture ends with the study, and waits for a free place", async () => {
  const ended: string[] = [];
  const over = ({ kind }: ApiProblem) => void ended.push(kind);
  const signal = new AbortController().signal;
  const refused = (status: number, kind: string) =>
    studyTicketSource(
      { visit: () => Promise.reject(new ApiProblem(status, kind, "", [], 2000)) },
      "k",
      "a",
      over,
    )(signal);
  expect(await refused(410, "study-closed")).toMatchObject({ ok: false, trouble: "link_ended", final: true });
  expect(await refused(503, "no-worker")).toMatchObject({ ok: false, trouble: "no_worker", retryAfterMs: 2000 });
  expect(await refused(0, "offline")).toMatchObject({ ok: false, trouble: "unreachable", final: false });
  const visit = (key: string, step: string) => Promise.resolve({ stream_url: `${key}/${step}` });
  expect(await studyTicketSource({ visit }, "k", "a", over)(signal)).toEqual({ ok: true, url: "k/a" });
  expect(ended).toEqual(["study-closed"]);
});

describe("the role", () => {
  const audience = (you: string, presenter: string) =>
    create(AudienceSchema, {
      you,
      presenter,
      participants: [
        { id: "owner", owner: true, presenter: presenter === "owner" },
        { id: "ann", presenter: presenter === "ann" },
      ],
    });

  it("is the presenter's while alone, and afterwards as the server says", () => {
    expect(roleOf(null)).toMatchObject({ presents: true, follows: false, others: 0 });
    expect(roleOf(audience("ann", "owner"))).toMatchObject({ presents: false, follows: true, others: 1 });
    expect(roleOf(audience("ann", "ann"))).toMatchObject({ presents: true, presenter: { id: "ann" } });
    expect(roleOf(audience("owner", "gone"))).toMatchObject({ follows: true, presenter: null });
  });
});
