import { create } from "@bufbuild/protobuf";
import { afterEach, describe, expect, it } from "vitest";
import { ChannelSchema, LabelLookSchema, type Rgb, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { hexOf, rgb, rgbOf } from "./colour";
import { comfortable, comfortOf, hasComfort, originalsOf, setAdoptedComfort, setComfort } from "./comfort";
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
    // Red cannot rise by 34 and has half its room. Green and blue are (25, 36).
    expect(hexOf(comfortable(rgbOf("#fb0404"), "blood", 1))).toBe("#fd1924");
  });
  it.each([rgb(0.95, 0.9, 0.8), rgb(0.9, 0.79, 0.6), rgb(0.97, 0.94, 0.88), rgbOf("#e8ba94")])(
    "never makes bone green or saturated",
    (original) => {
      for (let by = -2; by <= 2; by += 0.05) {
        const { r, g, b } = comfortable(original, "bone", by);
        expect(r).toBeGreaterThanOrEqual(g);
        expect(g).toBeGreaterThan(b);
        expect(r).toBeLessThanOrEqual(1);
      }
    },
  );
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
  it("leaves colours of the user and labels alone, again and again", () => {
    const labels = [create(LabelLookSchema, { number: 1, colour: rgbOf("#c82020") })];
    const own = { ...lookOf(channel("muscle", rgbOf("#804040")), bone), labels };
    let scene: Scene = own;
    for (const by of [1, 2, -2, 0.5]) scene = setComfort(scene, originals, by);
    expect(coloursOf(scene)[0]).toBe("#804040");
    expect(scene.labels).toBe(labels);
    expect(setComfort(scene, originals, 0)).toEqual(own);
  });
  it("is offered only where blood or bone is shown", () => {
    expect(hasComfort(look, originals)).toBe(true);
    expect(hasComfort(lookOf(channel("bone", rgbOf("#112233"))), originals)).toBe(false);
    expect(hasComfort(lookOf(skin), originals)).toBe(false);
    expect(hasComfort(lookOf(skin, { ...bone, disabled: true }), originals)).toBe(false);
  });
});

describe("the comfort that a study of this installation has found", () => {
  afterEach(() => setAdoptedComfort(null));

  it("replaces the published differences, until it is dropped", () => {
    const [reference, published] = [rgbOf("#fb0404"), "#fd1924"];
    expect(hexOf(comfortable(reference, "blood", 1))).toBe(published);
    setAdoptedComfort({ bone: [0, 0, 0], blood: [-20, 40, 10] });
    expect(hexOf(comfortable(reference, "blood", 1))).toBe("#e72c0e"); // (231, 44, 14)
    expect(hexOf(comfortable(rgbOf("#e8ba94"), "bone", 1))).toBe("#e8ba94");
    setAdoptedComfort(null);
    expect(hexOf(comfortable(reference, "blood", 1))).toBe(published);
  });
});
