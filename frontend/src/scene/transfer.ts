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

/** What scene/check_scene.cpp asks for, and within it what a person can mean. */
export const most_channels = 64;
export const most_points = 1024;
export const value_limits: Limits = { low: -1e9, high: 1e9 };
export const unit_limits: Limits = { low: 0, high: 1 };
export const density_limits: Limits = { low: 0.001, high: 100 };
export const emission_limits: Limits = { low: 0, high: 1000 };
export const longest_name = 60;
/** Voxels are whole numbers: points nearer to each other say nothing more. */
const least_gap = 1;

const empty = create(TransferFunctionSchema);
export const transfer_of = (scene: Scene): TransferFunction => scene.transferFunction ?? empty;
export const channels_of = (scene: Scene): readonly Channel[] => transfer_of(scene).channels;

const with_channels = (scene: Scene, channels: Channel[]): Scene => ({ ...scene, transferFunction: { ...transfer_of(scene), channels } });

function with_channel(scene: Scene, index: number, edit: (channel: Channel) => Channel): Scene {
  const channel = channels_of(scene)[index];
  if (!channel) return scene;
  const edited = edit(channel);
  return edited === channel ? scene : with_channels(scene, replaced(channels_of(scene), index, edited));
}

const with_points = (channel: Channel, opacity: OpacityPoint[]): Channel => ({ ...channel, opacity });
const point = (value: number, opacity: number): OpacityPoint => create(OpacityPointSchema, { value, opacity });

/** Between its neighbours; the first and the last may go as far as the protocol lets them. */
export function point_limits(channel: Channel, index: number): Limits {
  const below = channel.opacity[index - 1]?.value;
  const above = channel.opacity[index + 1]?.value;
  const here = channel.opacity[index]?.value ?? 0;
  // Where points already stand closer, half of what is left.
  const gap = (to: number | undefined) => (to === undefined ? 0 : Math.min(least_gap, Math.abs(here - to) / 2));
  return {
    low: below === undefined ? value_limits.low : below + gap(below),
    high: above === undefined ? value_limits.high : above - gap(above),
  };
}

export function move_point(scene: Scene, channel: number, index: number, to: { readonly value?: number; readonly opacity?: number }): Scene {
  return with_channel(scene, channel, (one) => {
    const old = one.opacity[index];
    if (!old) return one;
    const value = within(to.value ?? old.value, point_limits(one, index), old.value);
    const opacity = within(to.opacity ?? old.opacity, unit_limits, old.opacity);
    return value === old.value && opacity === old.opacity ? one : with_points(one, replaced(one.opacity, index, point(value, opacity)));
  });
}

/** On the curve where no opacity is said. Nothing where there is a point already, or no room for one. */
export function add_point(scene: Scene, channel: number, value: number, opacity?: number): { readonly scene: Scene; readonly index: number } | null {
  const one = channels_of(scene)[channel];
  if (!one || one.opacity.length >= most_points || !Number.isFinite(value) || Math.abs(value) > value_limits.high) return null;
  const above = one.opacity.findIndex((p) => p.value > value);
  const index = above < 0 ? one.opacity.length : above;
  const near = (p: OpacityPoint | undefined) => p !== undefined && Math.abs(p.value - value) < least_gap;
  if (near(one.opacity[index - 1]) || near(one.opacity[index])) return null;
  const added = point(value, within(opacity ?? opacity_at(one, value), unit_limits, 0));
  const points = [...one.opacity.slice(0, index), added, ...one.opacity.slice(index)];
  return { scene: with_channel(scene, channel, (c) => with_points(c, points)), index };
}

/** The middle of the widest gap: where a point is added without saying where. */
export function roomiest_value(channel: Channel): number {
  let widest = 0, middle = 0;
  channel.opacity.forEach((p, i) => {
    const next = channel.opacity[i + 1];
    if (!next || next.value - p.value <= widest) return;
    widest = next.value - p.value;
    middle = (p.value + next.value) / 2;
  });
  return middle;
}

/** A channel keeps two. */
export const remove_point = (scene: Scene, channel: number, index: number): Scene =>
  with_channel(scene, channel, (one) => (one.opacity.length <= 2 || !one.opacity[index] ? one : with_points(one, without(one.opacity, index))));

/** Zero outside of the first and the last point, linear between. */
export function opacity_at(channel: Channel, value: number): number {
  const above = channel.opacity.findIndex((p) => p.value >= value);
  const right = channel.opacity[above], left = channel.opacity[above - 1];
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

export const set_material = (scene: Scene, channel: number, material: Material): Scene =>
  with_channel(scene, channel, (one) => ({
    ...one,
    ...material,
    name: (material.name ?? one.name).slice(0, longest_name),
    gloss: within(material.gloss ?? one.gloss, unit_limits, one.gloss),
  }));

const fresh_colours = [[0.35, 0.62, 0.9], [0.45, 0.8, 0.4], [0.9, 0.55, 0.85], [0.95, 0.8, 0.35], [0.4, 0.8, 0.8]] as const;

/** A tent over the middle of the values. */
export function add_channel(scene: Scene, name: string, range: Limits): Scene {
  const channels = channels_of(scene);
  if (channels.length >= most_channels) return scene;
  const [r, g, b] = fresh_colours[channels.length % fresh_colours.length] ?? fresh_colours[0];
  const low = clamp(range.low, -1e6, 1e6);
  const width = Math.max(clamp(range.high, -1e6, 1e6) - low, 8);
  const at = (part: number) => Math.round(low + part * width);
  const opacity = [point(at(0.35), 0), point(at(0.5), 0.5), point(at(0.65), 0)];
  return with_channels(scene, [...channels, create(ChannelSchema, { name, diffuse: rgb(r, g, b), opacity })]);
}

/** A transfer function keeps one. */
export const remove_channel = (scene: Scene, index: number): Scene =>
  channels_of(scene).length <= 1 || !channels_of(scene)[index] ? scene : with_channels(scene, without(channels_of(scene), index));

export const set_density = (scene: Scene, extinctionPerMm: number): Scene => {
  const old = transfer_of(scene);
  return { ...scene, transferFunction: { ...old, extinctionPerMm: within(extinctionPerMm, density_limits, old.extinctionPerMm) } };
};

/** The whole function along the values, as far as all of its points may go. */
export function shifted(transfer: TransferFunction, by: number): TransferFunction {
  const values = transfer.channels.flatMap((channel) => channel.opacity.map((p) => p.value));
  const to = within(by, { low: value_limits.low - Math.min(...values), high: value_limits.high - Math.max(...values) }, 0);
  const channels = transfer.channels.map((channel) => with_points(channel, channel.opacity.map((p) => point(p.value + to, p.opacity))));
  return { ...transfer, channels };
}

/** Of the voxels and of all points: what the editor shows. */
export function shown_range(transfer: TransferFunction, minimum: number, maximum: number): Limits {
  const values = transfer.channels.flatMap((channel) => channel.opacity.map((p) => p.value));
  const low = Math.min(minimum, ...values), high = Math.max(maximum, ...values);
  return high > low ? { low, high } : { low, high: low + 1 };
}
