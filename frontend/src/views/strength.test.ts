import { expect, test } from "vitest";
import { shortestPassword, strengthOf } from "./strength";

test("states how many characters are missing, counted as users see them", () => {
  expect(strengthOf("")).toEqual({ level: 0, missing: shortestPassword });
  expect(strengthOf("éàüöèçñâêîû").missing).toBe(1);
  expect(strengthOf("👍👍🏽abcdefgh").missing).toBe(1);
  expect(strengthOf("kq7 zr4 vm2x")).toEqual({ level: 1, missing: 0 });
});

test("rises with the length, but not with repetition", () => {
  expect(strengthOf("kq7 zr4 vm2x p9w").level).toBe(2);
  expect(strengthOf("three blind mice run far").level).toBe(3);
  expect(strengthOf("aaaaaaaaaaaaaaaaaaaaaaaa").level).toBe(0);
  expect(strengthOf("abababababababababababab").level).toBeLessThan(2);
});
