import { describe, expect, it } from "vitest";
import { seriesNames } from "./series_names";

const names = (...all: [string, number | null][]) =>
  [
    ...seriesNames(
      all.map(([description, seriesNumber], i) => ({ key: `${i}`, description, fileName: "", seriesNumber })),
      "Untitled",
    ),
  ].map(([, name]) => name);

describe("the names of series", () => {
  it("are those of research files, which have no description", () => {
    const one = { key: "1", description: "", fileName: "brain.nii.gz", seriesNumber: null };
    expect([...seriesNames([one], "Untitled").values()]).toEqual(["brain.nii.gz"]);
  });
  it("are their descriptions", () => {
    expect(names(["Head", 1], ["", 2])).toEqual(["Head", "Untitled"]);
  });
  it("tell two series apart by their numbers, and two phases of one by their order", () => {
    expect(names(["Head", 4], ["Head", 7])).toEqual(["Head (4)", "Head (7)"]);
    expect(names(["", 3], ["", 3])).toEqual(["Untitled (1)", "Untitled (2)"]);
    expect(names(["", null], ["", null])).toEqual(["Untitled (1)", "Untitled (2)"]);
  });
});
