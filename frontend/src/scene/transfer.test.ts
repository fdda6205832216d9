import { describe, expect, it } from "vitest";
import { heights, outline } from "./histogram";
import { hexOf, hueOf, rgb, rgbOf, withHue } from "./colour";
import { shortNumber, typedNumber } from "./numbers";
import { resetPart } from "./parts";
import { someScene } from "./testing";
import {
  addChannel,
  addPoint,
  channelsOf,
  movePoint,
  opacityAt,
  pointLimits,
  removeChannel,
  removePoint,
  roomiestValue,
  setMaterial,
  shifted,
  shownRange,
  transferOf,
} from "./transfer";

const values = (scene = someScene(), channel = 1) => channelsOf(scene)[channel]?.opacity.map((p) => p.value);

describe("points of a channel", () => {
  it("never pass each other, however far they are dragged", () => {
    const far = movePoint(someScene(), 1, 1, { value: 99_999, opacity: 7 });
    expect(values(far)).toEqual([180, 3071, 3072]);
    expect(channelsOf(far)[1]?.opacity[1]?.opacity).toBe(1);
    expect(values(movePoint(someScene(), 1, 1, { value: -99_999 }))).toEqual([180, 181, 3072]);
  });

  it("keep their order if they are less than one value apart", () => {
    const close = shifted(transferOf(someScene()), 0);
    const points = [0, 0.25, 0.5].map((value, i) => ({
      ...(close.channels[0]?.opacity[i] ?? { $typeName: "diaphane.v1.OpacityPoint" as const, opacity: 0 }),
      value,
    }));
    const scene = {
      ...someScene(),
      transferFunction: { ...close, channels: close.channels.map((c, i) => (i === 0 ? { ...c, opacity: points } : c)) },
    };
    const moved = values(movePoint(scene, 0, 1, { value: 50 }), 0) ?? [];
    expect(moved[1]).toBeGreaterThan(0.25);
    expect(moved[1]).toBeLessThan(0.5);
  });

  it("can be added on the curve and removed, except for the last two", () => {
    const scene = someScene();
    const added = addPoint(scene, 1, 300);
    expect(added?.index).toBe(1);
    expect(added && channelsOf(added.scene)[1]?.opacity[1]?.opacity).toBeCloseTo(0.5, 12);
    expect(added && channelsOf(removePoint(added.scene, 1, 1))).toEqual(channelsOf(scene));
    const two = removePoint(scene, 1, 0);
    expect(removePoint(two, 1, 0)).toBe(two);
  });

  it("are not added where one exists or at an invalid value", () => {
    for (const value of [180, 180.4, NaN, Infinity, 1e12]) expect(addPoint(someScene(), 1, value)).toBeNull();
  });

  it("form lines between them and close the channel beyond the ends", () => {
    const [, bone] = channelsOf(someScene());
    expect(bone && [179.9, 180, 300, 420, 3072, 3073].map((v) => Number(opacityAt(bone, v).toFixed(6)))).toEqual([
      0, 0, 0.5, 1, 1, 0,
    ]);
    expect(bone && roomiestValue(bone)).toBe(1746);
  });

  it("have finite limits", () => {
    const [muscle] = channelsOf(someScene());
    expect(muscle && pointLimits(muscle, 1)).toEqual({ low: 6, high: 259 });
  });
});

describe("the whole function", () => {
  it("shifts by the given distance and back again", () => {
    const transfer = transferOf(someScene());
    expect(shifted(shifted(transfer, 123), -123)).toEqual(transfer);
    expect(shifted(transfer, 100).channels[1]?.opacity[0]?.value).toBe(280);
  });

  it("keeps at least one channel, and adds channels in new colours", () => {
    let scene = someScene();
    for (let i = 0; i < 100; i++) scene = addChannel(scene, "new", { low: -1000, high: 3000 });
    expect(channelsOf(scene).length).toBe(64);
    for (let i = 0; i < 100; i++) scene = removeChannel(scene, 0);
    expect(channelsOf(scene).length).toBe(1);
  });

  it("is shown with all its points and all values of the volume", () => {
    expect(shownRange(transferOf(someScene()), -1024, 2000)).toEqual({ low: -1024, high: 3072 });
  });

  it("is reset together with its part of the scene, and nothing else is", () => {
    const begun = someScene();
    const changed = { ...setMaterial(begun, 0, { name: "flesh", disabled: true }), bounces: 4 };
    const back = resetPart(changed, begun, "look");
    expect(back.transferFunction).toBe(begun.transferFunction);
    expect(back.bounces).toBe(4);
    expect(
      resetPart({ ...changed, clip: { $typeName: "diaphane.v1.Clip", planes: [], cutsLight: true } }, begun, "cuts")
        .clip,
    ).toBeUndefined();
    expect(resetPart({ ...changed, showTable: true }, begun, "cuts").showTable).toBe(false);
  });
});

describe("the histogram", () => {
  it("is not dwarfed by the air on the linear scale", () => {
    expect(heights([1_000_000, 10, 5, 0], false)).toEqual([1, 1, 0.5, 0]);
    expect(heights([0, 0], false)).toEqual([0, 0]);
    expect(heights([], true)).toEqual([]);
    const log = heights([999_999, 999, 0], true);
    expect(log[1]).toBeCloseTo(0.5, 3);
  });

  it("is at its values, also if the shown range is larger", () => {
    const line = outline({ minimum: 0, width: 10, counts: [4, 2] }, { low: -20, high: 80 }, 100, 50, true);
    expect(line.split(" ")[0]).toBe("20.0,50");
    expect(line.split(" ").at(-1)).toBe("40.0,50");
  });
});

describe("a typed number", () => {
  const limits = { low: -10, high: 100 };
  it("is a number within the limits, or null", () => {
    expect(["5", " 7,5 ", "\u22123", "1e1", ".5", "100"].map((text) => typedNumber(text, limits))).toEqual([
      5, 7.5, -3, 10, 0.5, 100,
    ]);
    for (const text of ["", " ", "5 mm", "0x10", "NaN", "Infinity", "1,2,3", "101", "-11", "1e9", "--5", "five"])
      expect(typedNumber(text, limits)).toBeNull();
  });

  it("is formatted as short as possible", () => {
    expect([0.1 + 0.2, -0.00001, 12345.678, 300, -0].map((n) => shortNumber(n))).toEqual([
      "0.3",
      "-0.00001",
      "12346",
      "300",
      "0",
    ]);
  });
});

describe("a colour", () => {
  it("is shown as it was chosen", () => {
    for (const hex of ["#000000", "#ffffff", "#0c6a73", "#010203", "#fe8040"]) expect(hexOf(rgbOf(hex))).toBe(hex);
    expect(hexOf(rgb(40, 20, 0))).toBe("#ffff00");
  });

  it("keeps the strength of a light when its hue changes", () => {
    const red = withHue(rgb(40, 38, 36), rgb(1, 0, 0));
    expect([red.r, red.g, red.b]).toEqual([40, 0, 0]);
    expect(hueOf(rgb(0, 0, 0))).toEqual(rgb(1, 1, 1));
  });
});
