import { afterEach, describe, expect, it } from "vitest";
import { loadTexts, t } from ".";
import "./testing";

afterEach(() => loadTexts("en"));

describe.each([
  { language: "en", area: "2,226 mm², 2,425 pixels", hours: ["20 h", "2.5 h"], skull: "Skull" },
  { language: "de", area: "2.226 mm², 2.425 Pixel", hours: ["20 h", "2,5 h"], skull: "Schädel" },
] as const)("the texts in $language", ({ language, area, hours, skull }) => {
  it("group the digits of an area like those of a count", async () => {
    await loadTexts(language);
    expect(t.slices.ellipseSize(2225.7, 2425)).toBe(area);
  });

  it("give hours without a needless zero", async () => {
    await loadTexts(language);
    expect([20, 2.5].map((n) => t.myAccount.hours(n * 3_600_000))).toEqual(hours);
  });

  it("write a typographic minus beside the sliders of a cut", async () => {
    await loadTexts(language);
    expect([t.cut.mm(-122), t.cut.degrees(-5)]).toEqual(["−122 mm", "−5°"]);
  });

  it("translate the title of the skull that comes with Diaphane", async () => {
    await loadTexts(language);
    expect(t.scans.sampleTitles.Cranium).toBe(skull);
  });
});
