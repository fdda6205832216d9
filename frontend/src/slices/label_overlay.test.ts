import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { LabelLookSchema, RgbSchema, type LabelLook } from "../protocol/gen/api/proto/scene_pb";
import { Labels_LabelSchema } from "../protocol/gen/api/proto/stream_pb";
import { foundParts } from "../scene/labels";
import { firstLabels, labelTable, showsLabels } from "./label_overlay";

const label = (number: number, colour: number) => create(Labels_LabelSchema, { number, name: "", colour });
const labels = [label(7, 0x102030), label(3, 0xff8000)];
const look = (number: number, rest: Partial<LabelLook>) => create(LabelLookSchema, { number, ...rest });
/** Returns red, green, blue and opacity by place. */
const rgba = (looks: readonly LabelLook[], strength = 1) => {
  const bytes = new Uint8Array(labelTable(labels, looks, strength).buffer);
  return [0, 1, 2, 3].map((place) => [...bytes.slice(4 * place, 4 * place + 4)]);
};
const none = [0, 0, 0, 0];

describe("the colours of labels in slices", () => {
  it("are those of the list by place, and transparent without a label", () => {
    expect(rgba([])).toEqual([none, [16, 32, 48, 255], [255, 128, 0, 255], none]);
    const red = look(3, { colour: create(RgbSchema, { r: 1 }) });
    expect(rgba([red])[2]).toEqual([255, 0, 0, 255]);
  });
  it("are as opaque as the label and the strength say", () => {
    expect(rgba([look(7, { opacity: 0.4 })], 0.5).map(([, , , opacity]) => opacity)).toEqual([0, 51, 128, 0]);
    expect(rgba([look(7, { opacity: 0 })])[1]?.[3]).toBe(0);
  });
  it("are only those of the label that is shown alone", () => {
    expect(rgba([look(3, { solo: true })]).map(([, , , opacity]) => opacity)).toEqual([0, 0, 255, 0]);
    expect(rgba([look(99, { solo: true })])[1]?.[3], "the scan has no such label").toBe(255);
  });
  it("are shown if somebody has marked something, until the user decides", () => {
    expect(showsLabels(firstLabels, [])).toBe(false);
    expect(showsLabels(firstLabels, labels)).toBe(true);
    const found = Object.values(foundParts).map((number) => label(number, 0));
    expect(showsLabels(firstLabels, found)).toBe(false);
    expect(showsLabels(firstLabels, [...found, ...labels])).toBe(true);
    expect(showsLabels({ shown: true, strength: 1 }, found)).toBe(true);
    expect(showsLabels({ shown: false, strength: 1 }, labels)).toBe(false);
  });
});
