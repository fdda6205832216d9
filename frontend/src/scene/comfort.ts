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

/** The changes of the colours for a comfort of 1: red, green and blue, of 255. */
export type ComfortDifferences = Readonly<Record<Material, readonly [number, number, number]>>;

/** The published changes (thesis, table 1, weighted difference). */
export const weightedDifferences: ComfortDifferences = {
  bone: [-30, 7, 6],
  blood: [34, 21, 32],
};

let differences = weightedDifferences;

/** Uses the changes that a study of this installation has found, or else the published ones. */
export function setAdoptedComfort(adopted: ComfortDifferences | null): void {
  differences = adopted ? { bone: adopted.bone, blood: adopted.blood } : weightedDifferences;
}

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

type Components = readonly [number, number, number];

const components = ({ r, g, b }: Rgb): Components => [255 * screenValue(r), 255 * screenValue(g), 255 * screenValue(b)];

/** The colour of bone from which the study's differences start (thesis, table 1). */
const boneReference = { red: 232, green: 186, blue: 148 };

/**
 * Returns bone changed by a comfort. The study started from a tan colour. Its differences would turn our nearly white
 * bone green, so they apply in proportion to the differences between the components: red never falls below green.
 */
function changedBone([red, green, blue]: Components, by: number): Components {
  const [dr, dg, db] = differences.bone;
  const of = boneReference;
  const most = (dr - dg) / (of.red - of.green); // change of red over green for a comfort of 1, negative
  const over = red - green;
  const towards = over * (by <= 1 ? 1 + most * by : (1 + most) ** by);
  const level = by > 0 ? Math.min(1, (255 - green) / (255 - of.green)) : green / of.green;
  const g = green + dg * by * level;
  const r = by < 0 ? red + dg * by * level - by * Math.min(-most * over, (255 - red) / 2) : g + towards;
  return [r, g, g - (green - blue) * (1 + ((dg - db) / (of.green - of.blue)) * by)];
}

/** Returns a component changed so that it reaches neither 0 nor 255 before the end of the scale. */
const changedBy = (of: number, change: number, by: number): number =>
  of + Math.abs(by) * clamp(Math.sign(by) * change, -of / 2, (255 - of) / 2);

/** Returns a colour changed by a comfort. */
export function comfortable(colour: Rgb, material: Material, by: number): Rgb {
  if (by === 0) return colour;
  const [dr, dg, db] = differences.blood;
  const [red, green, blue] = components(colour);
  const [r, g, b] =
    material === "bone"
      ? changedBone([red, green, blue], by)
      : [changedBy(red, dr, by), changedBy(green, dg, by), changedBy(blue, db, by)];
  const linear = (of: number) => fromScreen(clamp(of, 0, 255) / 255);
  return rgb(linear(r), linear(g), linear(b));
}

const isSame = (a: Rgb, b: Rgb): boolean => {
  const [p, q] = [components(a), components(b)];
  return p.every((of, i) => Math.abs(of - (q[i] ?? of)) < rounding);
};

/** The steps of the slider, from the smallest change on. */
const steps = Array.from({ length: 81 }, (_, i) => (i - 40) / 20).sort((a, b) => Math.abs(a) - Math.abs(b));

function nearestStep(comfort: number): number {
  return Math.round(20 * comfort) / 20;
}

/** Returns the comfort that makes `colour` of `original`, or null if it is another colour. */
const comfortBetween = (original: Rgb, colour: Rgb, material: Material): number | null =>
  steps.find((by) => isSame(comfortable(original, material, by), colour)) ?? null;

/** The original colours of the materials by their names, from the scan's looks. */
export type Originals = ReadonlyMap<string, Rgb>;

export function originalsOf(looks: readonly (Scene | undefined)[]): Originals {
  const originals = new Map<string, Rgb>();
  for (const look of looks)
    for (const { name, diffuse } of look ? channelsOf(look) : [])
      if (materials[name] && diffuse) originals.set(name, diffuse);
  return originals;
}

/** Returns the comfort of a material, or null if it has none: another material, or a colour that the user chose. */
function comfortOfChannel(channel: Channel, originals: Originals): number | null {
  const material = materials[channel.name];
  const original = originals.get(channel.name);
  return material && original && channel.diffuse ? comfortBetween(original, channel.diffuse, material) : null;
}

/** Whether a scene shows blood or bone in colours that a comfort can change. */
export const hasComfort = (scene: Scene, originals: Originals): boolean =>
  channelsOf(scene).some((channel) => !channel.disabled && comfortOfChannel(channel, originals) !== null);

/** Returns the comfort of a scene: that of its first material with an original colour, or else 0. */
export function comfortOf(scene: Scene, originals: Originals): number {
  for (const channel of channelsOf(scene)) {
    const by = comfortOfChannel(channel, originals);
    if (by !== null) return by;
  }
  return 0;
}

/**
 * Changes the comfort of a scene. What is visible stays. So do labels, and colours that the user chose, because the
 * way back to them would be unknown.
 */
export function setComfort(scene: Scene, originals: Originals, to: number): Scene {
  const by = nearestStep(clamp(to, comfortLimits.low, comfortLimits.high));
  if (by === comfortOf(scene, originals)) return scene;
  const channels = channelsOf(scene).map((channel) => {
    const material = materials[channel.name];
    const original = originals.get(channel.name);
    if (!material || !original || comfortOfChannel(channel, originals) === null) return channel;
    return { ...channel, diffuse: comfortable(original, material, by) };
  });
  return { ...scene, transferFunction: { ...transferOf(scene), channels } };
}
