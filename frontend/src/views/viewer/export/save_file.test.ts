import { expect, it } from "vitest";
import { timeInName } from "./save_file";

it("names a file after the moment it was saved", () => {
  expect(timeInName(new Date(2026, 2, 1, 9, 5, 7))).toBe("2026-03-01-090507");
});
