import { afterEach, expect, it } from "vitest";
import { loadTexts } from ".";
import { refusalText } from "./refusal";

afterEach(() => loadTexts("en"));

const overQuota = { code: "over_quota", text: "The 3D image of this scan takes 210 MB." };

it("uses the server's sentence in English", () => {
  expect(refusalText(overQuota)).toBe(overQuota.text);
});
it("uses the text of the reason in another language", async () => {
  await loadTexts("de");
  expect(refusalText(overQuota)).toContain("Speicherplatz");
  expect(refusalText({ code: "values_out_of_range", text: "x" })).toContain("Werte");
});
it("uses the sentence if the language has no text, or one that needs a number", async () => {
  await loadTexts("de");
  expect(refusalText({ code: "internal", text: "x" })).toBe("x");
  expect(refusalText({ code: "missing_slices", text: "3 slices are missing." })).toBe("3 slices are missing.");
  expect(refusalText({ code: "constructor", text: "x" })).toBe("x");
});
