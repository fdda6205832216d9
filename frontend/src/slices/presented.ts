import type { Vec3 } from "../input/vec3";
import type { Measure } from "./measure";
import type { RememberedSlices } from "./memory";
import type { Slab, Tilt } from "./oblique";
import type { Placing } from "./placing";
import type { Plane } from "./stack";
import type { Window } from "./window";

/** A single view, or all four. */
export type Shown = "picture" | "four" | Plane;

/** What a presenter shows of the slices. */
export interface PresentedSlices {
  /** The shown views. Null while only the picture is shown. */
  readonly view: Shown | null;
  readonly crosshair: Vec3;
  readonly window: Window;
  readonly smooth: boolean;
  /** Opacity of the look's colours over the grey, from 0 to 1. */
  readonly overlay: number;
  /** Opacity of the labels' colours over the grey, from 0 to 1. */
  readonly labels: number;
  readonly tilt: Tilt | null;
  readonly slab: Slab;
  readonly placings: Readonly<Partial<Record<Plane, Placing>>>;
}

/** The view to which a viewer returns after following someone else. */
export interface OwnView {
  readonly remembered: RememberedSlices;
  readonly shown: Shown;
  readonly placings: Partial<Record<Plane, Placing>>;
}

/** Maximum number of measurements that are presented, the newest ones. The server refuses more. */
export const mostPresented = 100;

/** Returns the measurements of both lists without duplicates. */
export function joined(first: readonly Measure[], second: readonly Measure[]): readonly Measure[] {
  const known = new Set(first.map((one) => JSON.stringify(one)));
  return [...first, ...second.filter((one) => !known.has(JSON.stringify(one)))];
}
