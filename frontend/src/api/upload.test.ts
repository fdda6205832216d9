import { describe, expect, it } from "vitest";
import { nextPartBytes, partBounds } from "./upload";

describe("the size of a part", () => {
  it("takes about two seconds, so that a pause loses little data", () => {
    expect(nextPartBytes(1 << 20, 1000)).toBe(2 << 20);
    expect(nextPartBytes(4 << 20, 8000)).toBe(1 << 20);
  });
  it("stays within bounds on very fast and very slow connections", () => {
    expect(nextPartBytes(1 << 20, 0)).toBe(partBounds.most);
    expect(nextPartBytes(1 << 18, 60_000)).toBe(partBounds.least);
  });
});
