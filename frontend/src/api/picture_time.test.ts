import { expect, test } from "vitest";
import { asked_again_ms, picture_time } from "./picture_time";

const minute = 60_000;
const left = (ms: number) => ({ quota_ms: 72_000_000, used_ms: 72_000_000 - ms, renewed_at: "2026-12-01T00:00:00.000Z", pictures_end_at: null });

test("five minutes before it ends it is said, and in the last minute anew", () => {
  expect(picture_time(left(5 * minute + 1))).toEqual({ kind: "enough" });
  expect(picture_time(left(5 * minute))).toEqual({ kind: "soon", minutes: 5 });
  expect(picture_time(left(2.5 * minute))).toEqual({ kind: "soon", minutes: 3 });
  expect(picture_time(left(minute))).toEqual({ kind: "soon", minutes: 1 });
  expect(picture_time(left(1))).toEqual({ kind: "soon", minutes: 1 });
  expect(picture_time(left(-1))).toEqual({ kind: "soon", minutes: 1 }); // the server has not said until when
});

test("when all is used, the moment counts at which the server ends the pictures", () => {
  const time = { ...left(0), pictures_end_at: "2026-11-22T12:02:00.000Z" };
  expect(picture_time(time)).toEqual({ kind: "ending", at_ms: Date.UTC(2026, 10, 22, 12, 2) });
});

test("three pictures at once do not run through a threshold unseen", () => {
  expect(asked_again_ms(left(72_000_000))).toBe(2 * minute);
  expect(asked_again_ms(left(8 * minute))).toBe(minute);
  expect(asked_again_ms(left(5.1 * minute))).toBe(5000);
  expect(asked_again_ms(left(4 * minute))).toBe(minute);
  expect(asked_again_ms(left(0.9 * minute))).toBe(18_000);
  expect(asked_again_ms(left(-minute))).toBe(5000);
});
