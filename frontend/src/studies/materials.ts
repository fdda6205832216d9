import { sceneFromJson, type Scene } from "../protocol/messages";
import { rgbOf } from "../scene/colour";
import { channelsOf, transferOf } from "../scene/transfer";
import type { Material, Step, Text, View, ViewStep } from "./definition";

/** The colours of bone and blood from which the published study started (thesis, figure 19). */
export const referenceColours: Readonly<Record<string, string>> = {
  bone: "#e8ba94",
  "spongy bone": "#e8ba94",
  vessels: "#fb0404",
  muscle: "#fb0404",
};

/** The names of the materials of the looks (renderd/scene/presets.cpp) for participants. */
const commonNames: Readonly<Record<string, Text>> = {
  bone: { en: "Bone", de: "Knochen" },
  "spongy bone": { en: "Spongy bone", de: "Schwammknochen" },
  vessels: { en: "Blood vessels", de: "Blutgefäße" },
  muscle: { en: "Muscle", de: "Muskeln" },
  skin: { en: "Skin", de: "Haut" },
  fat: { en: "Fat", de: "Fett" },
};

/** The materials that the published study let participants recolour, if the scene shows them. */
const usual = ["bone", "vessels"];

/** Returns the names of the materials that a scene shows. */
export const shownMaterials = (scene: Scene): string[] => [
  ...new Set(channelsOf(scene).flatMap(({ name, disabled }) => (disabled ? [] : [name]))),
];

export const firstMaterial = (channel: string): Material => ({
  channel,
  name: commonNames[channel] ?? { en: channel },
});

/** Returns a scene with the channels of a name in another colour ("#rrggbb"). */
export function withMaterialColour(scene: Scene, channel: string, hex: string): Scene {
  const channels = channelsOf(scene).map((one) => (one.name === channel ? { ...one, diffuse: rgbOf(hex) } : one));
  return { ...scene, transferFunction: { ...transferOf(scene), channels } };
}

/** Returns a step with another view. It keeps the materials that the view shows, or else gets the usual ones. */
export function withStepView(step: ViewStep, view: View): Step {
  if (step.kind === "latency") return { ...step, view: { ...view, start: "random" } };
  if (step.kind !== "colours") return { ...step, view };
  const scene = sceneFromJson(JSON.stringify(view.scene));
  const shown = scene ? shownMaterials(scene) : [];
  const kept = step.materials.filter(({ channel }) => shown.includes(channel));
  const materials = kept.length > 0 ? kept : usual.filter((name) => shown.includes(name)).map(firstMaterial);
  return { ...step, view, materials };
}
