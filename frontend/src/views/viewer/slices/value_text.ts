import type { Vec3 } from "../../../input/vec3";
import { Modality, type VolumeHeader } from "../../../protocol/messages";
import type { Slices } from "../../../slices/model";
import type { SecondValue } from "../../../slices/second_overlay";
import { blank, isInside } from "../../../slices/stack";
import { t } from "../../../texts";

const textOf = (value: number, modality: Modality | undefined): string =>
  modality === Modality.CT ? t.slices.hu(value) : t.slices.value(value);

/** Returns the text for a value at a place, which is null until it has arrived. */
export function valueText(
  { access }: Pick<Slices, "access">,
  volume: VolumeHeader,
  place: Vec3,
  value: number | null,
  interpolated: boolean,
): string {
  if (!isInside(volume, place)) return t.slices.nothing;
  if (value === null) return "…";
  if (value === blank && access.value !== "whole") return t.slices.cutAway;
  const text = textOf(value, volume.modality);
  return interpolated ? t.slices.interpolated(text) : text;
}

/** Adds the value of the second scan, if there is one. */
export const withSecond = (first: string, second: SecondValue | null): string =>
  second ? t.slices.both(first, textOf(second.value, second.modality)) : first;
