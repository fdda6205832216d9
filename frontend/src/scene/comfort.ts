import type { Channel, Rgb, Scene } from "../protocol/gen/api/proto/scene_pb";
import { fromScreen, rgb, screenValue } from "./colour";
import { clamp, type Limits } from "./numbers";
import { channelsOf, transferOf } from "./transfer";

/**
 * Comfort: how blood and bone are coloured, from -2 to 2. Participants of a study changed both colours until a picture
 * looked more comfortable to them. The scale extrapolates the mean of their changes linearly (thesis 6.1).
 */

export const comfortLimits: Limits = { low: -2, high: 2 };

type Material = "bone" | "blood";

/** The changes of the colours for a comfort of 1: red, green and blue, of 255 (thesis, table 1, weighted difference). */
export const weightedDifferences: Readonly<Record<Material, readonly [number, number, number]>> = {
  bone: [-30, 7, 6],
  blood: [34, 21, 32],
};

/** The materials of the looks (renderd/scene/presets.cpp) that contain bone, or are red from blood. */
const materials: Readonly<Record<string, Material>> = {
  bone: "bone",
  "spongy bone": "bone",
  enamel: "bone",
  muscle: "blood",
  vessels: "blood",
};

/** Differences of colour components below this are rounding. A step on the screen is 1. */
const rounding = 1e-3;

const components = ({ r, g, b }: Rgb): [number, number, number] => [
  255 * screenValue(r),
  255 * screenValue(g),
  255 * screenValue(b),
];

/** Returns a colour changed by a comfort. */
export function comfortable(colour: Rgb, material: Material, by: number): Rgb {
  if (by === 0) return colour;
  const changed = (of: number, change: number) => fromScreen(clamp(of + by * change, 0, 255) / 255);
  const [red, green, blue] = components(colour);
  const [r, g, b] = weightedDifferences[material];
  return rgb(changed(red, r), changed(green, g), changed(blue, b));
}

const isSame = (a: Rgb, b: Rgb): boolean => {
  const [p, q] = [components(a), components(b)];
  return p.every((of, i) => Math.abs(of - (q[i] ?? of)) < rounding);
};

/** Rounded, so that a colour always gives the same comfort, and a comfort the same colour. */
const rounded = (comfort: number): number => Math.round(comfort * 1000) / 1000;

/** Returns the material of a label by its own colour: saturated red is blood, and pale yellow or white is bone. */
function materialOf(colour: Rgb): Material | null {
  const [r, g, b] = components(colour);
  if (r > 110 && Math.max(g, b) < 0.55 * r) return "blood";
  return r > 220 && g > 180 && b > 140 && r >= g && g >= b ? "bone" : null;
}

/** Returns the comfort that makes `colour` of `original`, or null if it is another colour. */
function comfortBetween(original: Rgb, colour: Rgb, material: Material): number | null {
  const [from, to] = [components(original), components(colour)];
  // Solves for the component that no comfort clamps.
  const change = weightedDifferences[material];
  const free = [0, 1, 2].filter((i) => {
    const reach = Math.abs(2 * (change[i] ?? 0));
    return (from[i] ?? 0) - reach > 0 && (from[i] ?? 0) + reach < 255;
  });
  const solved = (free.length > 0 ? free : [0, 1, 2]).map((i) => ((to[i] ?? 0) - (from[i] ?? 0)) / (change[i] ?? 1));
  const by = solved.find((one) => Math.abs(one) > rounding) ?? 0;
  const within = clamp(by, comfortLimits.low, comfortLimits.high);
  return isSame(comfortable(original, material, within), colour) ? within : null;
}

/** The original colours of the materials by their names, from the scan's looks. */
export type Originals = ReadonlyMap<string, Rgb>;

export function originalsOf(looks: readonly (Scene | undefined)[]): Originals {
  const originals = new Map<string, Rgb>();
  for (const look of looks)
    for (const { name, diffuse } of look ? channelsOf(look) : [])
      if (materials[name] && diffuse) originals.set(name, diffuse);
  return originals;
}

const originalOf = (channel: Channel, originals: Originals): Rgb | undefined => originals.get(channel.name);

/** Whether a scene shows blood or bone, whose colours a comfort changes. */
export const hasComfort = (scene: Scene): boolean =>
  channelsOf(scene).some(({ name, disabled }) => !disabled && materials[name] !== undefined);

/** Returns the comfort of a scene: that of its first material with an original colour, or else 0. */
export function comfortOf(scene: Scene, originals: Originals): number {
  for (const channel of channelsOf(scene)) {
    const material = materials[channel.name];
    const original = originalOf(channel, originals);
    const by = material && original && channel.diffuse && comfortBetween(original, channel.diffuse, material);
    if (typeof by === "number") return rounded(by);
  }
  return 0;
}

/** Changes the comfort of a scene. What is visible stays. */
export function setComfort(scene: Scene, originals: Originals, to: number): Scene {
  const by = rounded(clamp(to, comfortLimits.low, comfortLimits.high));
  const now = comfortOf(scene, originals);
  if (by === now) return scene;
  const channels = channelsOf(scene).map((channel) => {
    const material = materials[channel.name];
    if (!material || !channel.diffuse) return channel;
    const original = originalOf(channel, originals);
    const known = original && comfortBetween(original, channel.diffuse, material) !== null;
    const base = known ? original : comfortable(channel.diffuse, material, -now);
    return { ...channel, diffuse: comfortable(base, material, by) };
  });
  const labels = scene.labels.map((look) => {
    if (!look.colour) return look;
    const { colour } = look;
    const material = (["blood", "bone"] as const).find((one) => materialOf(comfortable(colour, one, -now)) === one);
    return material ? { ...look, colour: comfortable(comfortable(colour, material, -now), material, by) } : look;
  });
  return { ...scene, transferFunction: { ...transferOf(scene), channels }, labels };
}
