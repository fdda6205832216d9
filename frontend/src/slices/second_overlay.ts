import { computed } from "@preact/signals";
import { Overlay_Mode as OverlayMode, type Overlay, type Scene } from "../protocol/gen/api/proto/scene_pb";
import type { SecondVolume } from "../protocol/gen/api/proto/stream_pb";
import type { VolumeHeader_Modality as Modality } from "../protocol/gen/api/proto/volume_pb";
import { lookColours, type LookColours } from "./look_colours";
import { blank } from "./stack";

/** The second scan of a session, and how the scene shows it. */
export interface SecondScan {
  readonly overlay: Overlay | undefined;
  readonly modality: Modality | undefined;
}

export interface SecondValue {
  readonly value: number;
  readonly modality: Modality | undefined;
}

export const secondScanOf = (second: SecondVolume | null, scene: Scene | null): SecondScan | null =>
  second && { overlay: scene?.overlay, modality: second.volume?.modality };

/** How a slice shows the second scan over the first. */
export interface SecondColours {
  /** RGBA by the bits of a value of the second scan, in the machine's byte order. */
  readonly table: Uint32Array;
  /** Opacity of black over the first scan, which hides it from a share of one half on. */
  readonly dimmed: number;
}

/** Returns the share of the second scan. A divider divides only the picture, so slices show both scans. */
export const shareOf = ({ mode, share }: Overlay): number => (mode === OverlayMode.SPLIT ? 0.5 : share);

/** Mixes as the picture does: the second scan fades in up to a share of one half, and from there the first fades out. */
export function secondColours(colours: LookColours, share: number): SecondColours {
  const table = new Uint32Array(65536);
  const bytes = new Uint8ClampedArray(table.buffer);
  bytes.set(colours);
  const opacity = Math.min(1, 2 * share);
  for (let i = 3; i < bytes.length; i += 4) bytes[i] = opacity * (colours[i] ?? 0);
  table[blank & 0xffff] = 0; // outside of the second scan
  return { table, dimmed: Math.max(0, 2 * share - 1) };
}

/** The second scan over slices of the first. `scan` reads signals. */
export class SecondOverlay {
  private readonly scan = computed(() => this.read());
  private readonly look = computed(() => this.scan.value?.overlay?.transferFunction ?? null);
  private readonly lookColours = computed(() => this.look.value && lookColours(this.look.value));
  /** How slices show the second scan, or null if there is none. */
  readonly colours = computed(() => {
    const overlay = this.scan.value?.overlay;
    return overlay && this.lookColours.value ? secondColours(this.lookColours.value, shareOf(overlay)) : null;
  });

  constructor(private readonly read: () => SecondScan | null) {}

  /** Returns null outside of the second scan. */
  valueOf(value = blank): SecondValue | null {
    return value === blank ? null : { value, modality: this.scan.value?.modality };
  }
}
