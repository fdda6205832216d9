import { describe, expect, it } from "vitest";
import { exportOrderOf, usualThreshold } from "./export_order";

const range = { minimum: -1024, maximum: 3071 };

describe("the order of a file of the scan", () => {
  it("contains only what its format needs", () => {
    const entries = { part: "5", above: "300" };
    expect(exportOrderOf({ ...entries, format: "nifti" }, range)).toEqual({ format: "nifti" });
    expect(exportOrderOf({ ...entries, format: "stl" }, range)).toEqual({ format: "stl", label: 5 });
    expect(exportOrderOf({ ...entries, part: "", format: "glb" }, range)).toEqual({ format: "glb", above: 300 });
  });

  it("is for the phase that is shown, if it is a surface of a value", () => {
    const entries = { part: "", above: "300" };
    expect(exportOrderOf({ ...entries, format: "stl" }, range, 3)).toEqual({ format: "stl", above: 300, phase: 3 });
    expect(exportOrderOf({ ...entries, format: "nifti" }, range, 3)).toEqual({ format: "nifti" });
    expect(exportOrderOf({ ...entries, part: "5", format: "stl" }, range, 3)).toEqual({ format: "stl", label: 5 });
  });

  it("accepts whole numbers within the scan, with either minus sign", () => {
    const order = (above: string) => exportOrderOf({ format: "stl", part: "", above }, range);
    expect([" -300 ", "−300", "-1024", "3071"].map(order).map((one) => one?.above)).toEqual([-300, -300, -1024, 3071]);
    for (const wrong of ["", "bone", "1.5", "1e3", "-1025", "3072", "--3"]) expect(order(wrong)).toBeNull();
  });
});

describe("the usual threshold", () => {
  it("is that of bone in a CT that contains bone", () => {
    expect(usualThreshold(range, true, [])).toBe(300);
    expect(usualThreshold({ minimum: -1024, maximum: 200 }, true, [0, 0, 0, 0, 40.4])).toBe(40);
  });

  it("is the upper quartile, or the middle of the values if that is unknown", () => {
    expect(usualThreshold({ minimum: 0, maximum: 900 }, false, [1, 2, 3, 4, 501.6, 700])).toBe(502);
    expect(usualThreshold({ minimum: 0, maximum: 901 }, false, [])).toBe(451);
    expect(usualThreshold({ minimum: 0, maximum: 9 }, false, [0, 0, 0, 0, 50])).toBe(9);
  });
});
