import type { DataSet, PresetName } from "../api/types";

type Modality = NonNullable<DataSet["volume"]>["modality"];

/**
 * Returns the looks that every scan of a kind has (renderd/scene/presets.cpp). Whether a scan also
 * has others depends on its values, and the stream lists them. Where no brain is found, the picture
 * of the brain is that of the surface.
 */
export const looksOfEvery = (modality: Modality): readonly PresetName[] =>
  modality === "CT" ? ["skin", "muscle", "bone", "through"] : ["skin", "muscle", "bone", "brain"];

/** Returns the look that suits the kind of scan. Only CT values distinguish bone. */
export const lookOf = (set: DataSet): PresetName => (set.volume && set.volume.modality !== "CT" ? "brain" : "bone");
