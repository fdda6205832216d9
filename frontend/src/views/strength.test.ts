import { expect, test } from "vitest";
import { shortest_password, strength_of } from "./strength";

test("says how many characters are missing, counted as people do", () => {
  expect(strength_of("")).toEqual({ level: 0, missing: shortest_password });
  expect(strength_of("éàüöèçñâêîû").missing).toBe(1);
  expect(strength_of("👍👍🏽abcdefgh").missing).toBe(1);
  expect(strength_of("kq7 zr4 vm2x")).toEqual({ level: 1, missing: 0 });
});

test("rises with the length and not with what is only repeated", () => {
  expect(strength_of("kq7 zr4 vm2x p9w").level).toBe(2);
  expect(strength_of("three blind mice run far").level).toBe(3);
  expect(strength_of("aaaaaaaaaaaaaaaaaaaaaaaa").level).toBe(0);
  expect(strength_of("abababababababababababab").level).toBeLessThan(2);
});
