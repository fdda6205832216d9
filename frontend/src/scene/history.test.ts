import { describe, expect, it } from "vitest";
import { changed, mostSteps, nothingYet, redone, rested, togetherMs, undone, type History } from "./history";

const step = (history: History<number>, before: number, what = "a", nowMs = 0, held = false) =>
  changed(history, before, { what, held, nowMs });

describe("undo", () => {
  it("goes back and forward step by step", () => {
    const two = step(step(nothingYet, 1, "a"), 2, "b");
    const once = undone(two, 3);
    const twice = once && undone(once.history, once.value);
    expect([once?.value, twice?.value]).toEqual([2, 1]);
    expect(twice && undone(twice.history, twice.value)).toBeNull();
    const forth = twice && redone(twice.history, twice.value);
    expect(forth?.value).toBe(2);
    expect(forth && redone(forth.history, forth.value)?.value).toBe(3);
  });

  it("treats each drag as one step, however long it takes", () => {
    let history: History<number> = nothingYet;
    for (let i = 0; i < 50; i++) history = step(history, i, "light", i * 5000, true);
    expect(history.past).toEqual([0]);
    history = step(rested(history), 50, "light", 250_001, true);
    expect(history.past).toEqual([0, 50]);
  });

  it("combines keys without a pause, but not with a pause or for two settings", () => {
    const near = step(step(nothingYet, 1, "camera", 0), 2, "camera", togetherMs - 1);
    expect(near.past).toEqual([1]);
    expect(step(near, 3, "camera", 3 * togetherMs).past).toEqual([1, 3]);
    expect(step(near, 3, "light", togetherMs).past).toEqual([1, 3]);
  });

  it("discards the undone steps after a new change", () => {
    const back = undone(step(nothingYet, 1), 2);
    expect(back && step(back.history, back.value).future).toEqual([]);
  });

  it("treats a change right after an undo as a step of its own", () => {
    const back = undone(step(step(nothingYet, 1, "a", 0), 2, "b", 1), 3);
    expect(back && step(back.history, back.value, "b", 2).past).toEqual([1, 2]);
  });

  it("keeps a limited number of steps", () => {
    let history: History<number> = nothingYet;
    for (let i = 0; i < 3 * mostSteps; i++) history = step(history, i, String(i));
    expect(history.past.length).toBe(mostSteps);
    expect(history.past.at(-1)).toBe(3 * mostSteps - 1);
  });
});
