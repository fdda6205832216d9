import { expect, it } from "vitest";
import { oneAtATime } from "./one_at_a_time";

it("ignores a second click until the first has ended, however it ended", async () => {
  const ends: (() => void)[] = [];
  const saved: string[] = [];
  const save = oneAtATime((name: string) => {
    saved.push(name);
    return new Promise<void>((resolve) => ends.push(resolve));
  });
  save("first");
  save("again");
  expect(saved).toEqual(["first"]);
  ends[0]?.();
  await new Promise((resolve) => setTimeout(resolve, 0));
  save("second");
  expect(saved).toEqual(["first", "second"]);
});
