import { expect, test } from "vitest";
import { worth_retrying } from "./upload";
import { begun, hindered, in_phase, is_open, next_to_send, refused, time_left, with_progress } from "./upload_view";

const sending = in_phase(begun("a", 100), "sending");

test("a hindrance is over when more has arrived than before it, not when a try begins", () => {
  const cut = hindered(with_progress(sending, 40, 0), "connection");
  expect(with_progress(cut, 0, 1000).phase).toBe("hindered");
  expect(with_progress({ ...cut, sent: 40 }, 40, 1000).phase).toBe("hindered");
  expect(with_progress({ ...cut, sent: 40 }, 41, 1000).phase).toBe("sending");
});

test("what the person has paused stays paused, whatever is told late", () => {
  const paused = in_phase(sending, "paused");
  expect(with_progress(paused, 50, 0).phase).toBe("paused");
  expect(hindered(paused, "connection").phase).toBe("paused");
});

test("the time that was waited does not count as slow sending", () => {
  let view = with_progress(with_progress(sending, 0, 0), 20, 4000);
  expect(time_left(view)).toBeCloseTo(16);
  view = with_progress(in_phase(in_phase(view, "paused"), "sending"), 20, 1_000_000);
  expect(time_left(view)).toBeNull();
});

test("each refusal has its reason", () => {
  const reason = (status: number) => refused(sending, { kind: "refused", status }).refusal;
  expect([401, 404, 410, 413, 400].map(reason)).toEqual(["signed_out", "gone", "expired", "too_large", "other"]);
  expect(is_open(refused(sending, { kind: "refused", status: 410 }))).toBe(false);
});

test("those that wait begin in their order, and only so many at once", () => {
  const waiting = ["a", "b", "c"].map((id) => begun(id, 100));
  expect(next_to_send(waiting, 2)).toBe("a");
  expect(next_to_send([sending, ...waiting.slice(1)], 2)).toBe("b");
  expect(next_to_send([sending, hindered(sending, "connection"), ...waiting], 2)).toBeNull();
  expect(next_to_send([in_phase(sending, "paused"), in_phase(sending, "elsewhere"), ...waiting], 1)).toBe("a");
});

test("what a later try can mend is tried again, what it cannot is not", () => {
  for (const status of [0, 408, 409, 423, 429, 460, 500, 502, 503, 507]) expect(worth_retrying(status, 99)).toBe(true);
  for (const status of [400, 401, 404, 410, 412, 413, 415, 422]) expect(worth_retrying(status, 0)).toBe(false);
  expect(worth_retrying(403, 0)).toBe(true);
  expect(worth_retrying(403, 9)).toBe(false);
});
