import { describe, expect, it } from "vitest";
import { pictureIn } from "./picture_in";

describe("the place of a picture in an area", () => {
  it("is all of it for a picture of its shape, also with rounded sides", () => {
    expect(pictureIn({ width: 800, height: 600 }, { width: 401, height: 300 }, false)).toEqual({
      x: 0,
      y: 0,
      width: 800,
      height: 600,
    });
  });
  it("is in the middle for a narrower picture", () => {
    expect(pictureIn({ width: 800, height: 600 }, { width: 300, height: 300 }, true)).toEqual({
      x: 100,
      y: 0,
      width: 600,
      height: 600,
    });
  });
  it("is cropped for a wider picture, unless that must fit", () => {
    const area = { width: 400, height: 800 };
    expect(pictureIn(area, { width: 200, height: 100 }, false)).toEqual({ x: -600, y: 0, width: 1600, height: 800 });
    expect(pictureIn(area, { width: 200, height: 100 }, true)).toEqual({ x: 0, y: 300, width: 400, height: 200 });
  });
});
