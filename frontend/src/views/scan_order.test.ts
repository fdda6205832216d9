import { describe, expect, it } from "vitest";
import { dateInTitle } from "../scan/title_date";
import { inOrder, scanOrderOf } from "./scan_order";

describe("the date in a title", () => {
  it.each([
    ["CT Head, 12 Mar 2024", "en-GB", "2024-03-12"],
    ["CT Head, Mar 12, 2024", "en-US", "2024-03-12"],
    ["CT Schädel, 12.03.2024", "de-DE", "2024-03-12"],
    ["Knie, 3. März 2024", "de-DE", "2024-03-03"],
    ["3/4/2024 chest", "en-US", "2024-03-04"],
    ["3/4/2024 chest", "en-GB", "2024-04-03"],
    ["2023-01-02 to 2024-05-06", "en-GB", "2024-05-06"],
  ])("is found in %s (%s)", (title, locale, wanted) => {
    expect(dateInTitle(title, locale)).toBe(Date.parse(wanted));
  });
  it("is not found in a title without one", () => {
    for (const title of ["", "Head 1", "T1 2024", "45.13.2024", "Series 12 of 2024"])
      expect(dateInTitle(title, "en-GB"), title).toBeNull();
  });
});

describe("the order of the scans", () => {
  const scan = (title: string, bytes: number | null) => ({
    title,
    created_at: "",
    volume:
      bytes === null
        ? null
        : {
            bytes,
            modality: "CT" as const,
            size: [1, 1, 1] as const,
            phases: 1,
            spacing_mm: [1, 1, 1] as const,
            repairs: [],
          },
  });
  const sets = [scan("Knee 10, 1 Jan 2025", 5), scan("", null), scan("Knee 2, 3 Mar 2026", 1), scan("Head", 9)];
  const titles = (order: Parameters<typeof inOrder>[1]) => inOrder(sets, order, "en-GB").map(({ title }) => title);
  it("is by date in the title, title or size, with what lacks it last", () => {
    expect(titles("added")).toEqual(sets.map(({ title }) => title));
    expect(titles("date")).toEqual(["Knee 2, 3 Mar 2026", "Knee 10, 1 Jan 2025", "", "Head"]);
    expect(titles("title")).toEqual(["Head", "Knee 2, 3 Mar 2026", "Knee 10, 1 Jan 2025", ""]);
    expect(titles("size")).toEqual(["Head", "Knee 10, 1 Jan 2025", "Knee 2, 3 Mar 2026", ""]);
  });
  it("is the server's unless a valid one was stored", () => {
    expect(scanOrderOf(null)).toBe("added");
    expect(scanOrderOf("colour")).toBe("added");
    expect(scanOrderOf("size")).toBe("size");
  });
});
