import type { LabelLook } from "../protocol/gen/api/proto/scene_pb";
import type { Labels_Label as Label } from "../protocol/gen/api/proto/stream_pb";
import { foundPart, isSolo, opacityOf, shownColour, type Looks } from "../scene/labels";

/** The labels of a scan in the order of the server, and how the scene shows them. */
export interface LabelSource {
  readonly labels: () => readonly Label[];
  readonly looks: () => readonly LabelLook[];
}
export const noLabels: LabelSource = { labels: () => [], looks: () => [] };

/** The colours of the labels over the grey. `shown` is null until the user decides. */
export interface LabelSetting {
  readonly shown: boolean | null;
  readonly strength: number;
}
export const firstLabels: LabelSetting = { shown: null, strength: 0.5 };

/**
 * Returns whether the slices show labels. Unless the user decides, they do if somebody has marked something. The parts
 * that the server has found cover most of a scan.
 */
export const showsLabels = ({ shown }: LabelSetting, labels: readonly Label[]): boolean =>
  labels.length > 0 && (shown ?? labels.some(({ number }) => foundPart(number) === undefined));

/** Returns the opacity of a label in slices: that of the list, and 0 while another label is shown alone. */
function visibility(scene: Looks, number: number, alone: boolean): number {
  return alone && !isSolo(scene, number) ? 0 : opacityOf(scene, number);
}

/**
 * Returns the colour of each place in the list of labels, from 1, as RGBA in the machine's byte order. Hidden labels
 * are transparent.
 */
export function labelTable(labels: readonly Label[], looks: readonly LabelLook[], strength: number): Uint32Array {
  const scene: Looks = { labels: [...looks] };
  const alone = labels.some(({ number }) => isSolo(scene, number));
  const table = new Uint32Array(256);
  const bytes = new Uint8ClampedArray(table.buffer);
  labels.forEach((label, i) => {
    const colour = Number.parseInt(shownColour(scene, label).slice(1), 16);
    bytes.set([colour >> 16, (colour >> 8) & 255, colour & 255], 4 * (i + 1));
    bytes[4 * (i + 1) + 3] = 255 * strength * visibility(scene, label.number, alone);
  });
  return table;
}
