import { create } from "@bufbuild/protobuf";
import {
  ChannelSchema,
  OpacityPointSchema,
  TransferFunctionSchema,
  type Channel,
  type OpacityPoint,
  type Scene,
  type TransferFunction,
} from "../protocol/gen/api/proto/scene_pb";
import { rgb } from "./colour";
import { clamp, replaced, within, without, type Limits } from "./numbers";

/** Limits that are useful and within those of scene/check_scene.cpp. */
export const mostChannels = 64;
export const mostPoints = 1024;
export const valueLimits: Limits = { low: -1e9, high: 1e9 };
export const unitLimits: Limits = { low: 0, high: 1 };
export const densityLimits: Limits = { low: 0.001, high: 100 };
export const emissionLimits: Limits = { low: 0, high: 1000 };
export const longestName = 60;
/** Voxel values are integers, so points that are closer together make no difference. */
const leastGap = 1;

const empty = create(TransferFunctionSchema);
export const transferOf = (scene: Scene): TransferFunction => scene.transferFunction ?? empty;
export const channelsOf = (scene: Scene): readonly Channel[] => transferOf(scene).channels;

const withChannels = (scene: Scene, channels: Channel[]): Scene => ({
  ...scene,
  transferFunction: { ...transferOf(scene), channels },
});

function withChannel(scene: Scene, index: number, edit: (channel: Channel) => Channel): Scene {
  const channel = channelsOf(scene)[index];
  if (!channel) return scene;
  const edited = edit(channel);
  return edited === channel ? scene : withChannels(scene, replaced(channelsOf(scene), index, edited));
}

const withPoints = (channel: Channel, opacity: OpacityPoint[]): Channel => ({ ...channel, opacity });
const point = (value: number, opacity: number): OpacityPoint => create(OpacityPointSchema, { value, opacity });

/**
 * Returns the limits of a point, which stays between its neighbours. The first and the last may
 * move to the limits of the protocol.
 */
export function pointLimits(channel: Channel, index: number): Limits {
  const below = channel.opacity[index - 1]?.value;
  const above = channel.opacity[index + 1]?.value;
  const here = channel.opacity[index]?.value ?? 0;
  // Where points are already closer together, the gap is half of the remaining distance.
  const gap = (to: number | undefined) => (to === undefined ? 0 : Math.min(leastGap, Math.abs(here - to) / 2));
  return {
    low: below === undefined ? valueLimits.low : below + gap(below),
    high: above === undefined ? valueLimits.high : above - gap(above),
  };
}

export function movePoint(
  scene: Scene,
  channel: number,
  index: number,
  to: { readonly value?: number; readonly opacity?: number },
): Scene {
  return withChannel(scene, channel, (one) => {
    const old = one.opacity[index];
    if (!old) return one;
    const value = within(to.value ?? old.value, pointLimits(one, index), old.value);
    const opacity = within(to.opacity ?? old.opacity, unitLimits, old.opacity);
    return value === old.value && opacity === old.opacity
      ? one
      : withPoints(one, replaced(one.opacity, index, point(value, opacity)));
  });
}

/**
 * Adds a point, on the curve unless an opacity is given. Returns null if there is a point already or no room for one.
 */
export function addPoint(
  scene: Scene,
  channel: number,
  value: number,
  opacity?: number,
): { readonly scene: Scene; readonly index: number } | null {
  const one = channelsOf(scene)[channel];
  if (!one || one.opacity.length >= mostPoints || !Number.isFinite(value) || Math.abs(value) > valueLimits.high)
    return null;
  const above = one.opacity.findIndex((p) => p.value > value);
  const index = above < 0 ? one.opacity.length : above;
  const near = (p: OpacityPoint | undefined) => p !== undefined && Math.abs(p.value - value) < leastGap;
  if (near(one.opacity[index - 1]) || near(one.opacity[index])) return null;
  const added = point(value, within(opacity ?? opacityAt(one, value), unitLimits, 0));
  const points = [...one.opacity.slice(0, index), added, ...one.opacity.slice(index)];
  return { scene: withChannel(scene, channel, (c) => withPoints(c, points)), index };
}

/** Returns the middle of the widest gap, where a point is added by default. */
export function roomiestValue(channel: Channel): number {
  let widest = 0,
    middle = 0;
  channel.opacity.forEach((p, i) => {
    const next = channel.opacity[i + 1];
    if (!next || next.value - p.value <= widest) return;
    widest = next.value - p.value;
    middle = (p.value + next.value) / 2;
  });
  return middle;
}

/** Removes a point, but keeps at least two per channel. */
export const removePoint = (scene: Scene, channel: number, index: number): Scene =>
  withChannel(scene, channel, (one) =>
    one.opacity.length <= 2 || !one.opacity[index] ? one : withPoints(one, without(one.opacity, index)),
  );

/**
 * Returns the opacity of a value: zero outside the first and the last point, and linear between
 * points.
 */
export function opacityAt(channel: Channel, value: number): number {
  const above = channel.opacity.findIndex((p) => p.value >= value);
  const right = channel.opacity[above],
    left = channel.opacity[above - 1];
  if (!right) return 0;
  if (right.value === value) return right.opacity;
  return left ? left.opacity + ((value - left.value) / (right.value - left.value)) * (right.opacity - left.opacity) : 0;
}

export interface Material {
  readonly name?: string;
  readonly disabled?: boolean;
  readonly diffuse?: Channel["diffuse"];
  readonly specular?: Channel["specular"];
  readonly gloss?: number;
  readonly emission?: Channel["emission"];
}

export const setMaterial = (scene: Scene, channel: number, material: Material): Scene =>
  withChannel(scene, channel, (one) => ({
    ...one,
    ...material,
    name: (material.name ?? one.name).slice(0, longestName),
    gloss: within(material.gloss ?? one.gloss, unitLimits, one.gloss),
  }));

const freshColours = [
  [0.35, 0.62, 0.9],
  [0.45, 0.8, 0.4],
  [0.9, 0.55, 0.85],
  [0.95, 0.8, 0.35],
  [0.4, 0.8, 0.8],
] as const;

/** Adds a channel with a triangle over the middle of the values. */
export function addChannel(scene: Scene, name: string, range: Limits): Scene {
  const channels = channelsOf(scene);
  if (channels.length >= mostChannels) return scene;
  const [r, g, b] = freshColours[channels.length % freshColours.length] ?? freshColours[0];
  const low = clamp(range.low, -1e6, 1e6);
  const width = Math.max(clamp(range.high, -1e6, 1e6) - low, 8);
  const at = (part: number) => Math.round(low + part * width);
  const opacity = [point(at(0.35), 0), point(at(0.5), 0.5), point(at(0.65), 0)];
  return withChannels(scene, [...channels, create(ChannelSchema, { name, diffuse: rgb(r, g, b), opacity })]);
}

/** Removes a channel, but keeps at least one. */
export const removeChannel = (scene: Scene, index: number): Scene =>
  channelsOf(scene).length <= 1 || !channelsOf(scene)[index]
    ? scene
    : withChannels(scene, without(channelsOf(scene), index));

export const setDensity = (scene: Scene, extinctionPerMm: number): Scene => {
  const old = transferOf(scene);
  return {
    ...scene,
    transferFunction: { ...old, extinctionPerMm: within(extinctionPerMm, densityLimits, old.extinctionPerMm) },
  };
};

/** Moves the whole function along the values, until one of its points reaches a limit. */
export function shifted(transfer: TransferFunction, by: number): TransferFunction {
  const values = transfer.channels.flatMap((channel) => channel.opacity.map((p) => p.value));
  const to = within(
    by,
    { low: valueLimits.low - Math.min(...values), high: valueLimits.high - Math.max(...values) },
    0,
  );
  const channels = transfer.channels.map((channel) =>
    withPoints(
      channel,
      channel.opacity.map((p) => point(p.value + to, p.opacity)),
    ),
  );
  return { ...transfer, channels };
}

/** Returns the range that the editor shows, which covers the voxels and all points. */
export function shownRange(transfer: TransferFunction, minimum: number, maximum: number): Limits {
  const values = transfer.channels.flatMap((channel) => channel.opacity.map((p) => p.value));
  const low = Math.min(minimum, ...values),
    high = Math.max(maximum, ...values);
  return high > low ? { low, high } : { low, high: low + 1 };
}
