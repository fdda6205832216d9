import { expect, test } from "vitest";
import { PhaseKind, phaseAt, phaseOf, usualRate } from "./phases";

const phases = (kind: PhaseKind, ...values: number[]) => values.map((value) => ({ kind, value }));
const beat = (count: number) => phases(PhaseKind.CYCLE, ...Array.from({ length: count }, (_, i) => (100 * i) / count));

test("a heartbeat takes a second, and times are played as they were recorded or in four seconds", () => {
  expect(usualRate(beat(20))).toBe(20);
  expect(usualRate(beat(10))).toBe(10);
  expect(usualRate(phases(PhaseKind.TIME, 0, 100, 200, 300))).toBe(10);
  expect(usualRate(phases(PhaseKind.TIME, ...Array.from({ length: 40 }, (_, i) => 2000 * i)))).toBe(10);
  expect(usualRate(phases(PhaseKind.ECHO, 4.6, 9.2))).toBe(2);
  expect(usualRate(phases(PhaseKind.INDEX, 0, 1, 2))).toBe(3);
  expect(usualRate([])).toBe(1);
});

test("equal times do not play at an infinite rate", () => {
  expect(usualRate(phases(PhaseKind.TIME, 5, 5, 5))).toBe(1);
});

test("a phase beyond the last one is the last one", () => {
  expect(phaseOf({ volumePhase: 7 }, 5)).toBe(4);
  expect(phaseOf({ volumePhase: 3 }, 5)).toBe(3);
  expect(phaseOf({ volumePhase: 3 }, 0)).toBe(0);
});

test("phases that cannot be shown in time are skipped, so that a heartbeat keeps its length", () => {
  // 20 phases per second: a renderer that asks every 130 ms gets every 2nd or 3rd phase, and 0 again after a second.
  const shown = [0, 130, 260, 390, 1000, 10_050].map((ms) => phaseAt(0, ms, 20, 20, true));
  expect(shown).toEqual([0, 2, 5, 7, 0, 1]);
});

test("phases end after the last one if they are not repeated", () => {
  expect(phaseAt(3, 0, 10, 5, false)).toBe(3);
  expect(phaseAt(3, 199, 10, 5, false)).toBe(4);
  expect(phaseAt(3, 200, 10, 5, false)).toBeNull();
  expect(phaseAt(3, 200, 10, 5, true)).toBe(0);
});
