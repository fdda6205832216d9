import { beforeAll, describe, expect, it } from "vitest";
import { loadTexts } from "../texts";
import { csvOf, curveFile, jsonOf, svgOf } from "./curve_file";
import { plotOf } from "./plot_scale";

const points = [1, 4, 16, 64].map((n) => ({ samples: 8 * n, seconds: 0.25 * n, error: 0.4 / Math.sqrt(n) }));
const source = { width: 1280, height: 720, device: "NVIDIA <H200>" };

beforeAll(() => loadTexts("en"));

describe("a saved curve", () => {
  it("is a table with a header that says what the error is, and in which units", () => {
    const lines = csvOf(points, source).trimEnd().split("\n");
    const header = lines.filter((line) => line.startsWith("# ")).join(" ");
    for (const said of ["per pixel", "in seconds", "root mean square", "0.05 is 5%", "1280 × 720", "NVIDIA <H200>"])
      expect(header).toContain(said);
    expect(lines.slice(-5)).toEqual(["samples,seconds,error", "8,0.25,0.4", "32,1,0.2", "128,4,0.1", "512,16,0.05"]);
  });
  it("is JSON with the same words and points", () => {
    const document = JSON.parse(jsonOf(points, source)) as Record<string, unknown>;
    expect(document.format).toBe("diaphane-error-curve");
    expect(document.points).toEqual(points);
    expect(document.width).toBe(1280);
    expect(document.units).toEqual({
      samples: "samples per pixel",
      seconds: "s of rendering time",
      error: "relative RMSE, 1 = black to white",
    });
    expect(String(document.about)).toContain("root mean square");
  });
  it("is a drawing with labelled log-log axes, the guide, and the curve that the page draws", () => {
    const drawing = svgOf(points, source);
    expect(drawing).toContain("NVIDIA &lt;H200&gt;");
    for (const said of ["Rendering time in s", "Noise level (relative error)", "Samples per pixel", "Slope −1/2"])
      expect(drawing).toContain(said);
    const numbers = [...drawing.matchAll(/<text[^>]*>([^<]+)<\/text>/g)].map(([, text]) => text);
    for (const number of ["1", "10", "1%", "10%", "100%", "100"]) expect(numbers).toContain(number);
    expect(drawing).toContain(`points="${plotOf(points, 530, 290)?.line ?? ""}"`);
    expect(drawing).toContain(`points="${plotOf(points, 530, 290)?.guide ?? ""}"`);
  });
  it("has the type of its format", () => {
    expect(curveFile("svg", points, source).type).toBe("image/svg+xml");
    expect(curveFile("csv", points, source).type).toBe("text/csv");
    expect(curveFile("json", points, source).type).toBe("application/json");
  });
});
