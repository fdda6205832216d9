import { describe, expect, it } from "vitest";
import { load_texts } from "../texts";
import { bytes_text, date_text, dicom_date_text, number_text } from "./format";

describe("texts of numbers", () => {
  it("bytes are counted as discs are", () => {
    expect([0, 999, 1000, 14_512_128, 2e10].map(bytes_text)).toEqual(["0 bytes", "999 bytes", "1.0 KB", "14.5 MB", "20.0 GB"]);
  });
  it("have the decimal sign and the months of the language", async () => {
    expect([number_text(1.23456), number_text(-0.00001), number_text(12345.6), number_text(-0)]).toEqual(["1.235", "-0.00001", "12346", "0"]);
    await load_texts("de");
    expect([number_text(1.23456), number_text(-0.00001), number_text(12345.6)]).toEqual(["1,235", "-0,00001", "12346"]);
    expect(bytes_text(14_512_128)).toBe("14,5 MB");
    expect(date_text("2026-12-01T12:00:00Z")).toMatch(/^01\.12\.2026/);
    await load_texts("en");
  });
  it("a date of a scan is a day, whatever the time zone; something else is none", () => {
    expect(dicom_date_text("19370413")).toMatch(/1937/);
    expect(dicom_date_text("1937.04.13")).toBe(dicom_date_text("19370413"));
    expect([dicom_date_text(""), dicom_date_text("yesterday")]).toEqual(["", ""]);
  });
});
