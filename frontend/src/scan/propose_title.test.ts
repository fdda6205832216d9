import { describe, expect, it } from "vitest";
import { proposedTitle, proposedTitles } from "./propose_title";

const patient = { name: "Erika de Mustermann", id: "P-4711", birthDate: "" };
const series = { description: "Head 0.6  H60s", bodyPart: "HEAD", modality: "CT", patient };

describe("the proposed title", () => {
  it("is what the series shows, and its date", () => {
    expect(proposedTitle(series, "3 Feb 2018")).toBe("Head 0.6 H60s, 3 Feb 2018");
    expect(proposedTitle(series, "")).toBe("Head 0.6 H60s");
    expect(proposedTitle({ ...series, description: "" }, "3 Feb 2018")).toBe("CT HEAD, 3 Feb 2018");
    expect(proposedTitle({ description: "", bodyPart: "", modality: "", patient }, "3 Feb 2018")).toBe("3 Feb 2018");
  });
  it("never names the patient", () => {
    expect(proposedTitle({ ...series, description: "MUSTERMANN^Erika Kopf" }, "")).toBe("CT HEAD");
    expect(proposedTitle({ ...series, description: "Scan 4711" }, "")).toBe("CT HEAD");
    expect(proposedTitle({ ...series, description: "Coupe de face" }, "")).toBe("Coupe de face");
  });
  it("keeps the date when the description is long", () => {
    const title = proposedTitle({ ...series, description: "a".repeat(200) }, "3 Feb 2018");
    expect(title).toHaveLength(80);
    expect(title.endsWith(", 3 Feb 2018")).toBe(true);
  });
  it("is never the same for two series of a disc", () => {
    const titlesOf = (...many: readonly Partial<typeof series & { date: string; seriesNumber: number | null }>[]) => {
      const all = many.map((one, i) => ({ ...series, date: "3 Feb 2018", seriesNumber: null, key: `${i}`, ...one }));
      return [...proposedTitles(all, (date) => date).values()];
    };
    expect(titlesOf({}, { description: "Lung" })).toEqual(["Head 0.6 H60s, 3 Feb 2018", "Lung, 3 Feb 2018"]);
    expect(titlesOf({}, {})).toEqual(["Head 0.6 H60s (1), 3 Feb 2018", "Head 0.6 H60s (2), 3 Feb 2018"]);
    expect(titlesOf({ seriesNumber: 4 }, { seriesNumber: 7 })).toEqual([
      "Head 0.6 H60s (4), 3 Feb 2018",
      "Head 0.6 H60s (7), 3 Feb 2018",
    ]);
    const bare = { description: "", bodyPart: "", modality: "" };
    expect(titlesOf(bare, bare)).toEqual(["3 Feb 2018 (1)", "3 Feb 2018 (2)"]);
    expect(titlesOf({ ...bare, date: "" }, { ...bare, date: "" })).toEqual(["", ""]);
  });
});
