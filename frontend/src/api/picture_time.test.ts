import { expect, test } from "vitest";
import { pollDelayMs, pictureTime } from "./picture_time";

const minute = 60_000;
const left = (ms: number) => ({
  quota_ms: 72_000_000,
  used_ms: 72_000_000 - ms,
  renewed_at: "2026-12-01T00:00:00.000Z",
  pictures_end_at: null,
});

test("announces the end five minutes before, and again in the last minute", () => {
  expect(pictureTime(left(5 * minute + 1))).toEqual({ kind: "enough" });
  expect(pictureTime(left(5 * minute))).toEqual({ kind: "soon", minutes: 5 });
  expect(pictureTime(left(2.5 * minute))).toEqual({ kind: "soon", minutes: 3 });
  expect(pictureTime(left(minute))).toEqual({ kind: "soon", minutes: 1 });
  expect(pictureTime(left(1))).toEqual({ kind: "soon", minutes: 1 });
  expect(pictureTime(left(-1))).toEqual({ kind: "soon", minutes: 1 }); // the server has not said until when
});

test("shows when the server will end the sessions once the time is used up", () => {
  const time = { ...left(0), pictures_end_at: "2026-11-22T12:02:00.000Z" };
  expect(pictureTime(time)).toEqual({ kind: "ending", atMs: Date.UTC(2026, 10, 22, 12, 2) });
});

test("notices a threshold that three pictures reach together", () => {
  expect(pollDelayMs(left(72_000_000))).toBe(2 * minute);
  expect(pollDelayMs(left(8 * minute))).toBe(minute);
  expect(pollDelayMs(left(5.1 * minute))).toBe(5000);
  expect(pollDelayMs(left(4 * minute))).toBe(minute);
  expect(pollDelayMs(left(0.9 * minute))).toBe(18_000);
  expect(pollDelayMs(left(-minute))).toBe(5000);
});
