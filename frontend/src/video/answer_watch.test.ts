import { beforeEach, expect, test } from "vitest";
import { AnswerWatch } from "./answer_watch";

let now = 0;
let sent = 0;
let shown = 0;
let owed = true;
let task: (() => void) | null = null;
let watch: AnswerWatch;

beforeEach(() => {
  [now, sent, shown, owed, task] = [0, 1, 1, true, null];
  watch = new AnswerWatch({
    sentInput: () => sent,
    shownInput: () => shown,
    isOwed: () => owed,
    nowMs: () => now,
    after: (ms, next) => {
      expect(ms).toBe(500);
      task = next;
      return () => (task = null);
    },
  });
  watch.start();
});

function wait(ms: number): void {
  for (let passed = 0; passed < ms; passed += 500) {
    now += 500;
    task?.();
  }
}

test("says within 3 s that a change brought no picture, and takes it back with the picture", () => {
  wait(10_000);
  expect(watch.late.value).toBe(false);
  sent = 2;
  wait(2500);
  expect(watch.late.value).toBe(false);
  wait(500);
  expect(watch.late.value).toBe(true);
  shown = 2;
  wait(500);
  expect(watch.late.value).toBe(false);
});

test("a picture of an earlier change is an answer while the user keeps dragging", () => {
  for (let step = 0; step < 10; step++) {
    sent += 5;
    shown += 1;
    wait(2000);
    expect(watch.late.value).toBe(false);
  }
});

test("owes nothing for a refused change, to a follower, or before the first picture", () => {
  sent = 2;
  watch.refuse(2);
  wait(10_000);
  expect(watch.late.value).toBe(false);
  sent = 3;
  owed = false;
  wait(10_000);
  expect(watch.late.value).toBe(false);
  owed = true;
  shown = 0;
  wait(10_000);
  expect(watch.late.value).toBe(false);
});

test("stops", () => {
  sent = 2;
  wait(5000);
  expect(watch.late.value).toBe(true);
  watch.stop();
  expect(watch.late.value).toBe(false);
  expect(task).toBe(null);
});
