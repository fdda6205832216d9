import { describe, expect, it } from "vitest";
import { bytes_text, dicom_date_text } from "./format";

describe("texts of numbers", () => {
  it("bytes are counted as discs are", () => {
    expect([0, 999, 1000, 14_512_128, 2e10].map(bytes_text)).toEqual(["0 bytes", "999 bytes", "1.0 KB", "14.5 MB", "20.0 GB"]);
  });
  it("a date of a scan is a day, whatever the time zone; something else is none", () => {
    expect(dicom_date_text("19370413")).toMatch(/1937/);
    expect(dicom_date_text("1937.04.13")).toBe(dicom_date_text("19370413"));
    expect([dicom_date_text(""), dicom_date_text("yesterday")]).toEqual(["", ""]);
  });
});
