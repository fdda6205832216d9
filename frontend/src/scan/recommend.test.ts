import { describe, expect, it } from "vitest";
import { recommend } from "./recommend";
import type { Series } from "./types";

const series = (key: string, slices: number, lengthMm: number): Series =>
  ({ key, verdict: { suitable: true, size: [512, 512, slices], sizeMm: [250, 250, lengthMm] } }) as unknown as Series;
const hidden = { key: "x", verdict: { suitable: false, reason: "scout", count: 1 } } as unknown as Series;

describe("the recommended series", () => {
  it("is the one with the thinnest slices", () => {
    expect(recommend([series("thick", 60, 180), series("thin", 300, 180)])).toEqual({
      key: "thin",
      why: { kind: "thinnest", mm: 0.6 },
    });
  });
  it("covers the body, not a detail of it", () => {
    expect(recommend([series("inner ear", 100, 30), series("head", 180, 180)])?.key).toBe("head");
  });
  it("is the longest of those that are equally thin", () => {
    expect(recommend([series("short", 150, 150), series("long", 200, 200)])).toEqual({
      key: "long",
      why: { kind: "largest", mm: 200 },
    });
  });
  it("is none where there is no choice", () => {
    expect(recommend([series("only", 100, 100), hidden])).toBeNull();
  });
});
