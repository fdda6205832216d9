import { create } from "@bufbuild/protobuf";
import { RgbSchema, type Rgb } from "../protocol/gen/api/proto/scene_pb";
import { clamp } from "./numbers";

export const rgb = (r: number, g: number, b: number): Rgb => create(RgbSchema, { r, g, b });
const none = rgb(0, 0, 0);

/** Returns a linear component in [0, 1] as sRGB. */
export const screenValue = (linear: number): number =>
  linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
/** Returns an sRGB component as linear. */
export const fromScreen = (value: number): number =>
  value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;

/** Returns a linear colour as sRGB ("#rrggbb"). Components above 1 are clamped. */
export function hexOf(colour: Rgb | undefined): string {
  const { r, g, b } = colour ?? none;
  return `#${[r, g, b]
    .map((c) =>
      Math.round(255 * screenValue(clamp(c, 0, 1)))
        .toString(16)
        .padStart(2, "0"),
    )
    .join("")}`;
}

/** Returns a linear colour, or black for invalid text. */
export function rgbOf(hex: string): Rgb {
  const parts = /^#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i.exec(hex);
  const [r = 0, g = 0, b = 0] = parts ? parts.slice(1).map((part) => fromScreen(parseInt(part, 16) / 255)) : [];
  return rgb(r, g, b);
}

export const strengthOf = (colour: Rgb | undefined): number => (colour ? Math.max(colour.r, colour.g, colour.b) : 0);

/**
 * Returns the hue of a colour whose components may exceed 1: the colour scaled so that its largest component is 1.
 * White for black.
 */
export function hueOf(colour: Rgb | undefined): Rgb {
  const strength = strengthOf(colour);
  return colour && strength > 0 ? scaled(colour, 1 / strength) : rgb(1, 1, 1);
}

export const scaled = ({ r, g, b }: Rgb, by: number): Rgb => rgb(r * by, g * by, b * by);

/** Changes the hue and keeps the strength. A black `hue` counts as white. */
export const withHue = (colour: Rgb | undefined, hue: Rgb): Rgb => scaled(hueOf(hue), strengthOf(colour));
