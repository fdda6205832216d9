import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { OverlayLookSchema } from "../protocol/gen/api/proto/scene_pb";
import { OverlayMode, overlayLookOf, setOverlayMode, setShare, setSplit, withOverlayLook } from "./overlay";
import { someScene } from "./testing";

const look = (name: string, extinctionPerMm: number) =>
  create(OverlayLookSchema, { name, overlay: { transferFunction: { extinctionPerMm }, share: 0.4 } });
const looks = [look("hot", 1), look("bone", 2)];
const [hot, bone] = looks as [(typeof looks)[number], (typeof looks)[number]];

describe("the second scan of a scene", () => {
  it("begins as its look has it, and keeps the mixture with another look", () => {
    const begun = withOverlayLook(someScene(), hot);
    expect(begun.overlay?.share).toBe(0.4);
    const other = withOverlayLook(setShare(begun, 0.9), bone);
    expect(other.overlay?.share).toBe(0.9);
    expect(overlayLookOf(other, looks)).toBe("bone");
  });

  it("is unchanged by settings while it is not shown", () => {
    const scene = someScene();
    expect(setShare(scene, 0.3)).toBe(scene);
    expect(overlayLookOf(scene, looks)).toBeNull();
  });

  it("has a divider in the middle at first, which stays in the picture", () => {
    const split = setOverlayMode(withOverlayLook(someScene(), hot), OverlayMode.SPLIT);
    expect(split.overlay).toMatchObject({ mode: OverlayMode.SPLIT, split: 0.5, share: 0.4 });
    expect(setSplit(split, 1.5).overlay?.split).toBe(1);
    const back = setOverlayMode(setSplit(split, 0.2), OverlayMode.MIXED);
    expect(setOverlayMode(back, OverlayMode.SPLIT).overlay?.split).toBe(0.2);
  });

  it("has a share between 0 and 1", () => {
    expect(setShare(withOverlayLook(someScene(), hot), -3).overlay?.share).toBe(0);
  });
});
