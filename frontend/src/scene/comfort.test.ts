import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { ChannelSchema, LabelLookSchema, type Rgb, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { hexOf, rgb, rgbOf } from "./colour";
import { comfortable, comfortOf, hasComfort, originalsOf, setComfort } from "./comfort";
import { someScene } from "./testing";
import { transferOf } from "./transfer";

const channel = (name: string, diffuse: Rgb) =>
  create(ChannelSchema, { name, diffuse, opacity: [{ value: 0 }, { value: 1, opacity: 0.7 }] });
const lookOf = (...channels: ReturnType<typeof channel>[]): Scene => {
  const scene = someScene();
  return { ...scene, transferFunction: { ...transferOf(scene), channels }, labels: [] };
};
const coloursOf = (scene: Scene) => transferOf(scene).channels.map(({ diffuse }) => hexOf(diffuse));

// The colours of the looks (renderd/scene/presets.cpp).
const muscle = channel("muscle", rgb(0.58, 0.13, 0.11));
const bone = channel("bone", rgb(0.95, 0.9, 0.8));
const skin = channel("skin", rgb(0.82, 0.49, 0.36));
const look = lookOf(skin, muscle, bone);
const originals = originalsOf([look]);

describe("comfort", () => {
  it("changes the colours of the study by the weighted differences of table 1", () => {
    // Bone #e8ba94 is (232, 186, 148), and blood #fb0404 is (251, 4, 4).
    expect(hexOf(comfortable(rgbOf("#e8ba94"), "bone", 1))).toBe("#cac19a"); // (202, 193, 154)
    expect(hexOf(comfortable(rgbOf("#e8ba94"), "bone", -2))).toBe("#ffac88"); // (292 clamped, 172, 136)
    expect(hexOf(comfortable(rgbOf("#fb0404"), "blood", 2))).toBe("#ff2e44"); // (319 clamped, 46, 68)
    expect(hexOf(comfortable(rgbOf("#fb0404"), "blood", -1))).toBe("#d90000"); // (217, below 0, below 0)
  });
  it("changes blood and bone, and neither skin nor what is visible", () => {
    const softer = setComfort(look, originals, 1.5);
    const [skinAfter, muscleAfter, boneAfter] = coloursOf(softer);
    const [skinBefore, muscleBefore, boneBefore] = coloursOf(look);
    expect(skinAfter).toBe(skinBefore);
    expect(muscleAfter).not.toBe(muscleBefore);
    expect(boneAfter).not.toBe(boneBefore);
    const opacities = (scene: Scene) => transferOf(scene).channels.map(({ opacity }) => opacity);
    expect(opacities(softer)).toEqual(opacities(look));
    expect(transferOf(softer).extinctionPerMm).toBe(transferOf(look).extinctionPerMm);
  });
  it("is read from the colours, and goes back to exactly the original ones", () => {
    for (const by of [-2, -1.3, 0.1, 1, 2]) {
      const changed = setComfort(look, originals, by);
      expect(comfortOf(changed, originals)).toBe(by);
      expect(setComfort(changed, originals, 0)).toEqual(look);
      expect(setComfort(setComfort(look, originals, -2), originals, by)).toEqual(changed);
    }
    expect(setComfort(look, originals, 9)).toEqual(setComfort(look, originals, 2));
  });
  it("also changes a material that the user has coloured, by the same difference", () => {
    const own = lookOf(channel("muscle", rgbOf("#804040")), bone);
    const softer = setComfort(own, originals, 1);
    expect(coloursOf(softer)[0]).toBe("#a25560"); // (128 + 34, 64 + 21, 64 + 32)
    expect(coloursOf(setComfort(softer, originals, 0))[0]).toBe("#804040");
  });
  it("changes labels that are coloured like blood or bone, and leaves the others", () => {
    const labels = ["#c82020", "#fff0d8", "#3080e0"].map((hex, i) =>
      create(LabelLookSchema, { number: i + 1, colour: rgbOf(hex) }),
    );
    const softer = setComfort({ ...look, labels }, originals, 1);
    expect(softer.labels.map(({ colour }) => hexOf(colour))).toEqual(["#ea3540", "#e1f7de", "#3080e0"]);
    const back = setComfort(softer, originals, 0);
    expect(back.labels.map(({ colour }) => hexOf(colour))).toEqual(["#c82020", "#fff0d8", "#3080e0"]);
  });
  it("is offered only where blood or bone is shown", () => {
    expect(hasComfort(look)).toBe(true);
    expect(hasComfort(lookOf(skin))).toBe(false);
    expect(hasComfort(lookOf(skin, { ...bone, disabled: true }))).toBe(false);
  });
});
