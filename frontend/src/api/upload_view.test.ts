import { expect, test } from "vitest";
import { worthRetrying } from "./upload";
import { begun, stalled, inPhase, isOpen, nextToSend, refused, timeLeft, withProgress } from "./upload_view";

const sending = inPhase(begun("a", 100), "sending");

test("a stall ends when new data has arrived, not when a retry begins", () => {
  const cut = stalled(withProgress(sending, 40, 0), "connection");
  expect(withProgress(cut, 0, 1000).phase).toBe("stalled");
  expect(withProgress({ ...cut, sent: 40 }, 40, 1000).phase).toBe("stalled");
  expect(withProgress({ ...cut, sent: 40 }, 41, 1000).phase).toBe("sending");
});

test("a paused upload stays paused despite late events", () => {
  const paused = inPhase(sending, "paused");
  expect(withProgress(paused, 50, 0).phase).toBe("paused");
  expect(stalled(paused, "connection").phase).toBe("paused");
});

test("waiting time does not count as slow sending", () => {
  let view = withProgress(withProgress(sending, 0, 0), 20, 4000);
  expect(timeLeft(view)).toBeCloseTo(16);
  view = withProgress(inPhase(inPhase(view, "paused"), "sending"), 20, 1_000_000);
  expect(timeLeft(view)).toBeNull();
});

test("each refusal has its reason", () => {
  const reason = (status: number) => refused(sending, { kind: "refused", status }).refusal;
  expect([401, 404, 410, 413, 400].map(reason)).toEqual(["signed_out", "gone", "expired", "too_large", "other"]);
  expect(isOpen(refused(sending, { kind: "refused", status: 410 }))).toBe(false);
});

test("waiting uploads start in order, up to a maximum number at once", () => {
  const waiting = ["a", "b", "c"].map((id) => begun(id, 100));
  expect(nextToSend(waiting, 2)).toBe("a");
  expect(nextToSend([sending, ...waiting.slice(1)], 2)).toBe("b");
  expect(nextToSend([sending, stalled(sending, "connection"), ...waiting], 2)).toBeNull();
  expect(nextToSend([inPhase(sending, "paused"), inPhase(sending, "elsewhere"), ...waiting], 1)).toBe("a");
});

test("only errors that a later try can fix are retried", () => {
  for (const status of [0, 408, 409, 423, 429, 460, 500, 502, 503, 507]) expect(worthRetrying(status, 99)).toBe(true);
  for (const status of [400, 401, 404, 410, 412, 413, 415, 422]) expect(worthRetrying(status, 0)).toBe(false);
  expect(worthRetrying(403, 0)).toBe(true);
  expect(worthRetrying(403, 9)).toBe(false);
});
