import { describe, expect, it } from "vitest";
import { loadTexts } from "../texts";
import { bytesText, dateText, dicomDateText, numberText } from "./format";

describe("texts of numbers", () => {
  it("use decimal units for bytes", () => {
    expect([0, 999, 1000, 14_512_128, 2e10].map(bytesText)).toEqual([
      "0 bytes",
      "999 bytes",
      "1.0 KB",
      "14.5 MB",
      "20.0 GB",
    ]);
  });
  it("have the decimal separator and the month names of the language", async () => {
    expect([numberText(1.23456), numberText(-0.00001), numberText(12345.6), numberText(-0)]).toEqual([
      "1.235",
      "-0.00001",
      "12346",
      "0",
    ]);
    await loadTexts("de");
    expect([numberText(1.23456), numberText(-0.00001), numberText(12345.6)]).toEqual(["1,235", "-0,00001", "12346"]);
    expect(bytesText(0)).toBe("0 Byte");
    expect(bytesText(14_512_128)).toBe("14,5 MB");
    expect(dateText("2026-12-01T12:00:00Z")).toMatch(/^01\.12\.2026/);
    await loadTexts("en");
  });
  it("format the date of a scan independently of the time zone, and reject an invalid one", () => {
    expect(dicomDateText("19370413")).toMatch(/1937/);
    expect(dicomDateText("1937.04.13")).toBe(dicomDateText("19370413"));
    expect([dicomDateText(""), dicomDateText("yesterday")]).toEqual(["", ""]);
  });
});
