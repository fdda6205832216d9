import { describe, expect, it } from "vitest";
import { Paced } from "./paced";

describe("a paced sender", () => {
  const tasks: (() => void)[] = [];
  const passed: number[] = [];
  const paced = new Paced<number>(
    100,
    (_, task) => {
      tasks.push(task);
      return () => tasks.splice(tasks.indexOf(task), 1);
    },
    (value) => passed.push(value),
  );
  const next = () => tasks.shift()?.();

  it("passes on the first value at once, and then only the newest one of each period", () => {
    for (const value of [1, 2, 3]) paced.push(value);
    expect(passed).toEqual([1]);
    next();
    expect(passed).toEqual([1, 3]);
    next();
    expect(tasks).toEqual([]);
    paced.push(4);
    expect(passed).toEqual([1, 3, 4]);
  });
  it("passes on nothing after it was stopped", () => {
    paced.push(5);
    paced.stop();
    expect(tasks).toEqual([]);
    expect(passed).not.toContain(5);
  });
});
