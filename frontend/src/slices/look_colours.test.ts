import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { ChannelSchema, TransferFunctionSchema } from "../protocol/gen/api/proto/scene_pb";
import { lookColours } from "./look_colours";
import { tableOf } from "./window";

const channel = (points: readonly (readonly [number, number])[], r: number, g: number, b: number, disabled = false) =>
  create(ChannelSchema, {
    diffuse: { r, g, b },
    disabled,
    opacity: points.map(([value, opacity]) => ({ value, opacity })),
  });
const look = (...channels: ReturnType<typeof channel>[]) =>
  lookColours(create(TransferFunctionSchema, { channels, extinctionPerMm: 1 }));
const at = (colours: Uint8ClampedArray, value: number) => [
  ...colours.slice(4 * (value & 0xffff), 4 * (value & 0xffff) + 4),
];

const red = channel(
  [
    [-100, 0],
    [0, 0.5],
    [100, 0],
  ],
  1,
  0,
  0,
);

describe("the colours of a look", () => {
  it("are those of its materials, as visible as their opacity relative to its maximum", () => {
    const colours = look(red);
    expect(at(colours, 0)).toEqual([255, 0, 0, 255]);
    expect(at(colours, -50)).toEqual([255, 0, 0, 128]);
    expect(at(colours, 101)).toEqual([0, 0, 0, 0]);
    expect(at(colours, -101)).toEqual([0, 0, 0, 0]);
    expect(at(colours, -32768)).toEqual([0, 0, 0, 0]); // what is cut away
  });
  it("mix by the opacity in linear light, and ignore hidden materials", () => {
    const blue = channel(
      [
        [0, 0.5],
        [1, 0.5],
      ],
      0,
      0,
      1,
    );
    // Half of the light of the screen is 188 in sRGB.
    expect(at(look(red, blue), 0)).toEqual([188, 0, 188, 255]);
    const hidden = channel(
      [
        [0, 1],
        [1, 1],
      ],
      0,
      1,
      0,
      true,
    );
    expect(at(look(red, hidden), 0)).toEqual([255, 0, 0, 255]);
  });
  it("may have points between and beyond the values of voxels", () => {
    const wide = look(
      channel(
        [
          [-1e9, 1],
          [0.5, 1],
          [0.5, 0],
          [1e9, 0],
        ],
        1,
        1,
        1,
      ),
    );
    expect(at(wide, -32768)).toEqual([255, 255, 255, 255]);
    expect(at(wide, 0)[3]).toBe(255);
    expect(at(wide, 1)[3]).toBe(0);
  });
});

describe("the table of a window", () => {
  it("blends the colours of a look over the grey", () => {
    const window = { centre: 0, width: 200 };
    const pixel = (strength: number, value: number) => {
      const rgba = tableOf(window, { colours: look(red), strength })[value & 0xffff] ?? 0;
      return [rgba & 255, (rgba >> 8) & 255, (rgba >> 16) & 255, rgba >>> 24];
    };
    expect(pixel(1, 0)).toEqual([255, 0, 0, 255]);
    expect(pixel(0.5, 0)).toEqual([192, 64, 64, 255]); // half of grey 128 and half of red
    expect(pixel(0.5, 50)).toEqual([207, 143, 143, 255]); // a quarter of red over grey 191
    expect(pixel(1, 150)).toEqual([255, 255, 255, 255]); // no material of the look
    expect(pixel(0, 0)).toEqual([128, 128, 128, 255]);
  });
});
