import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { Overlay_Mode as OverlayMode, OverlaySchema } from "../protocol/gen/api/proto/scene_pb";
import { secondColours, shareOf } from "./second_overlay";
import { blank } from "./stack";

/** Value 5 is opaque red, and -3 is half transparent blue. */
const colours = new Uint8ClampedArray(4 * 65536);
colours.set([255, 0, 0, 255], 4 * 5);
colours.set([0, 0, 255, 128], 4 * (-3 & 0xffff));
colours.set([0, 255, 0, 255], 4 * (blank & 0xffff));

const at = (share: number, value: number) => {
  const bytes = new Uint8Array(secondColours(colours, share).table.buffer);
  return [...bytes.slice(4 * (value & 0xffff), 4 * (value & 0xffff) + 4)];
};

describe("the second scan in slices", () => {
  it("fades in up to a share of one half", () => {
    expect([0, 0.25, 0.5, 1].map((share) => at(share, 5))).toEqual([0, 128, 255, 255].map((part) => [255, 0, 0, part]));
    expect(at(0.25, -3)).toEqual([0, 0, 255, 64]);
    expect(at(1, 6)).toEqual([0, 0, 0, 0]);
  });
  it("hides the first scan from a share of one half on", () => {
    expect([0, 0.5, 0.75, 1].map((share) => secondColours(colours, share).dimmed)).toEqual([0, 0, 0.5, 1]);
  });
  it("is transparent outside of the second scan", () => {
    expect(at(1, blank)).toEqual([0, 0, 0, 0]);
  });
  it("is shown with the first one if the picture is divided", () => {
    expect(shareOf(create(OverlaySchema, { share: 0.9 }))).toBe(0.9);
    expect(shareOf(create(OverlaySchema, { mode: OverlayMode.SPLIT, share: 0.9 }))).toBe(0.5);
  });
});
