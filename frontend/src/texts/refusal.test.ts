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
it("takes the number that the reason's text needs from the sentence", async () => {
  await loadTexts("de");
  expect(refusalText({ code: "missing_slices", text: "3 slices are missing." })).toContain("3 Schichten");
});
it("is the sentence where the language has no text, or no number for it", async () => {
  await loadTexts("de");
  expect(refusalText({ code: "internal", text: "x" })).toBe("x");
  expect(refusalText({ code: "missing_slices", text: "Slices are missing." })).toBe("Slices are missing.");
  expect(refusalText({ code: "constructor", text: "x" })).toBe("x");
});
