import { clamp } from "../scene/numbers";
import type { LookColours } from "./look_colours";

/** The range of values shown between black and white. */
export interface Window {
  readonly centre: number;
  readonly width: number;
}

export const windowLimits = { centre: { low: -32768, high: 32767 }, width: { low: 1, high: 65535 } } as const;

export const bounded = ({ centre, width }: Window): Window => ({
  centre: clamp(Math.round(centre), windowLimits.centre.low, windowLimits.centre.high),
  width: clamp(Math.round(width), windowLimits.width.low, windowLimits.width.high),
});

/**
 * Returns a grey level: 0 at the window's lower limit, 255 at its upper limit (LINEAR_EXACT of
 * DICOM PS3.3 C.11.2.1.3.2).
 */
export function greyOf(value: number, { centre, width }: Window): number {
  return Math.round(255 * clamp((value - centre) / width + 0.5, 0, 1));
}

/** The colours of a look over the grey. With `strength` 1, they hide it. */
export interface Overlay {
  readonly colours: LookColours;
  readonly strength: number;
}

/**
 * Returns a table that is indexed by the bits of a 16-bit value, for one lookup per pixel. Entries are RGBA in the
 * machine's byte order.
 */
export function tableOf(window: Window, overlay: Overlay | null = null): Uint32Array {
  const table = new Uint32Array(65536);
  const bytes = new Uint8ClampedArray(table.buffer);
  for (let bits = 0; bits < 65536; ++bits) {
    const grey = greyOf(bits < 32768 ? bits : bits - 65536, window);
    const part = overlay ? (overlay.strength * (overlay.colours[4 * bits + 3] ?? 0)) / 255 : 0;
    for (let i = 0; i < 3; ++i)
      bytes[4 * bits + i] = part > 0 ? grey + part * ((overlay?.colours[4 * bits + i] ?? 0) - grey) : grey;
    bytes[4 * bits + 3] = 255;
  }
  return table;
}

/** Writes one RGBA pixel per value to `into`. */
export function shade(values: Int16Array, table: Uint32Array, into: Uint32Array): void {
  for (let i = 0; i < values.length; ++i) into[i] = table[(values[i] ?? 0) & 0xffff] ?? 0;
}

/**
 * Returns the window after a drag: to the right widens it, and down lowers it. `right` and `down` are fractions of the
 * view, whose full size stands for `range` values.
 */
export function dragged(from: Window, right: number, down: number, range: number): Window {
  return bounded({ centre: from.centre - down * range, width: from.width + right * range });
}

/** The usual windows for CT, in HU. */
export const usualWindows = {
  soft: { centre: 40, width: 400 },
  lung: { centre: -600, width: 1500 },
  bone: { centre: 400, width: 1800 },
  brain: { centre: 40, width: 80 },
} as const satisfies Record<string, Window>;
export type UsualWindow = keyof typeof usualWindows;

interface Known {
  readonly windowCenter: number;
  readonly windowWidth: number;
  readonly minimum: number;
  readonly maximum: number;
  readonly percentiles: readonly number[];
}

/** What the slices read of the header of a volume. */
export type ScanHeader = Known & { readonly contentHash: string; readonly spacing: readonly number[] };

/** Returns the window stored in the scan, or one that covers nearly all of its values. */
export function firstWindow({ windowCenter, windowWidth, minimum, maximum, percentiles }: Known): Window {
  if (windowWidth > 0) return bounded({ centre: windowCenter, width: windowWidth });
  const low = percentiles[0] ?? minimum;
  const high = percentiles[6] ?? maximum;
  return high > low
    ? bounded({ centre: (low + high) / 2, width: high - low })
    : bounded({ centre: (minimum + maximum) / 2, width: Math.max(1, maximum - minimum) });
}
