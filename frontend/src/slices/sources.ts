import type { ReadonlySignal } from "@preact/signals";
import type { Scene, TransferFunction } from "../protocol/gen/api/proto/scene_pb";
import type { Labels_Label as Label, SecondVolume } from "../protocol/gen/api/proto/stream_pb";
import { noLabels, type LabelSource } from "./label_overlay";
import { secondScanOf, type SecondScan } from "./second_overlay";

/** What slices show in colour. The functions read signals. */
export interface SliceSources extends LabelSource {
  readonly look: () => TransferFunction | null;
  readonly second: () => SecondScan | null;
}
export const noSources: SliceSources = { ...noLabels, look: () => null, second: () => null };

export const sourcesOf = (
  scene: () => Scene | null,
  labels: ReadonlySignal<readonly Label[]>,
  second: ReadonlySignal<SecondVolume | null>,
): SliceSources => ({
  look: () => scene()?.transferFunction ?? null,
  labels: () => labels.value,
  looks: () => scene()?.labels ?? [],
  second: () => secondScanOf(second.value, scene()),
});
