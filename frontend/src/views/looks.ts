import type { DataSet, PresetName } from "../api/types";

type Modality = NonNullable<DataSet["volume"]>["modality"];

/**
 * Returns the looks of which every scan of a kind has a picture (renderd/scene/presets.cpp).
 * Whether a scan also has others depends on its values, and the stream lists them. If the server
 * finds no brain, it shows the surface in the picture of the brain.
 */
export const looksOfEvery = (modality: Modality): readonly PresetName[] =>
  modality === "CT" ? ["skin", "muscle", "bone", "through"] : ["skin", "muscle", "bone", "brain"];

/** Returns the look for a scan's picture in lists. Only CT values distinguish bone. */
export const lookOf = (set: DataSet): PresetName => (set.volume && set.volume.modality !== "CT" ? "brain" : "bone");
