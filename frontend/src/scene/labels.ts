import { create, equals } from "@bufbuild/protobuf";
import { LabelLookSchema, type LabelLook, type Rgb, type Scene } from "../protocol/gen/api/proto/scene_pb";
import type { Labels_Label as Label } from "../protocol/gen/api/proto/stream_pb";
import { hexOf, rgbOf } from "./colour";
import { within } from "./numbers";

/**
 * How the labels of a scan are shown. A label without a look is shown like the material at its
 * place.
 */

/** The label number of voxels that belong to no label. */
export const unlabelled = 0;

/** The label numbers of the parts that the server finds (kFoundParts in volume/labels.h). */
export const foundParts = {
  brain: 0xffffff04,
  bone: 0xffffff05,
  lungs: 0xffffff06,
  airways: 0xffffff07,
  vessels: 0xffffff08,
} as const;
export type FoundPart = keyof typeof foundParts;

/** Returns which part the server has found under this number, or undefined if somebody has marked the label. */
export const foundPart = (number: number): FoundPart | undefined =>
  (Object.keys(foundParts) as FoundPart[]).find((part) => foundParts[part] === number);

/** The look that shows the matter of each part best. */
export const lookOfPart: Readonly<Record<FoundPart, string>> = {
  brain: "brain",
  bone: "bone",
  lungs: "airways",
  airways: "airways",
  vessels: "vessels",
};

/** Returns the colour that the file of labels suggests. */
export const suggestedColour = ({ colour }: Pick<Label, "colour">): Rgb =>
  rgbOf(`#${colour.toString(16).padStart(6, "0")}`);

/** What this file reads of a scene. */
export type Looks = Pick<Scene, "labels">;

export const lookOf = (scene: Looks, number: number): LabelLook | undefined =>
  scene.labels.find((look) => look.number === number);

export const opacityOf = (scene: Looks, number: number): number => lookOf(scene, number)?.opacity ?? 1;
export const isShown = (scene: Scene, number: number): boolean => opacityOf(scene, number) > 0;
export const isSolo = (scene: Looks, number: number): boolean => lookOf(scene, number)?.solo ?? false;

/** Changes the look of one label. A look that changes nothing is left out. */
function withLook(scene: Scene, number: number, edit: (look: LabelLook) => LabelLook): Scene {
  const before = lookOf(scene, number) ?? create(LabelLookSchema, { number });
  const look = edit(before);
  const plain = look.colour === undefined && (look.opacity ?? 1) === 1 && !look.solo;
  const others = scene.labels.filter((one) => one.number !== number);
  const labels = plain ? others : [...others, look].sort((a, b) => a.number - b.number);
  return { ...scene, labels };
}

export const setColour = (scene: Scene, number: number, colour: Rgb): Scene =>
  withLook(scene, number, (look) => ({ ...look, colour }));

export const setOpacity = (scene: Scene, number: number, opacity: number): Scene =>
  withLook(scene, number, (look) => ({
    ...look,
    opacity: within(opacity, { low: 0, high: 1 }, look.opacity ?? 1),
  }));

export const setShown = (scene: Scene, number: number, shown: boolean): Scene =>
  setOpacity(scene, number, shown ? 1 : 0);

/**
 * Returns how labels are shown when the look changes to that of the preset `to`: as the preset
 * says, except for labels that the user has changed. A label counts as unchanged if one of the
 * presets `from` shows it in the same way.
 */
export function labelsAfter(scene: Scene, from: readonly Scene[], to: Scene): LabelLook[] {
  const offered = from.flatMap(({ labels }) => labels);
  const isOffered = (look: LabelLook) => offered.some((one) => equals(LabelLookSchema, one, look));
  const chosen = scene.labels.filter((look) => !isOffered(look));
  const others = to.labels.filter(({ number }) => !chosen.some((look) => look.number === number));
  return [...others, ...chosen].sort((a, b) => a.number - b.number);
}

/** Shows only this label, or all of them again. */
export function setSolo(scene: Scene, number: number, solo: boolean): Scene {
  const others = { ...scene, labels: scene.labels.map((look) => ({ ...look, solo: false })) };
  return withLook(others, number, (look) => ({ ...look, solo }));
}

const isColoured = (scene: Scene, { number }: Label): boolean => lookOf(scene, number)?.colour !== undefined;
export const areColoured = (scene: Scene, labels: readonly Label[]): boolean =>
  labels.some((label) => isColoured(scene, label));

/** Gives labels without a colour the one of their file, or removes the colours of all. */
export const setColoured = (scene: Scene, labels: readonly Label[], coloured: boolean): Scene =>
  labels.reduce(
    (now, label) =>
      coloured
        ? isColoured(now, label)
          ? now
          : setColour(now, label.number, suggestedColour(label))
        : withLook(now, label.number, ({ number, opacity, solo }) =>
            create(LabelLookSchema, { number, solo, ...(opacity === undefined ? {} : { opacity }) }),
          ),
    scene,
  );

/** Returns the colour of a label in a list: its own, or the one that its file suggests. */
export const shownColour = (scene: Looks, label: Label): string =>
  hexOf(lookOf(scene, label.number)?.colour ?? suggestedColour(label));
