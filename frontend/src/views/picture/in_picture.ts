import type { Point } from "../../input/flat";
import { computed, signal } from "@preact/signals";

/** The windows that have handles in the picture. */
export type HandleSet = "cuts" | "light";

/**
 * A request to choose a point of the picture, from 0 to 1 from the top left. `pick` returns a
 * message to show, or null if the request is complete.
 */
export interface Picking {
  readonly label: string;
  readonly pick: (at: Point) => Promise<string | null>;
  /** The label of the button that ends the request, unless it is "Cancel". */
  readonly end?: string;
}

/** The handles in the picture: those of the open windows, and those that stay after their window is closed. */
export class InPicture {
  readonly open = signal<readonly HandleSet[]>([]);
  readonly kept = signal<readonly HandleSet[]>([]);
  readonly picking = signal<Picking | null>(null);
  /** The light that the light window shows. */
  readonly light = signal(0);
  readonly shown = computed<readonly HandleSet[]>(() =>
    (["cuts", "light"] as const).filter((one) => this.open.value.includes(one) || this.kept.value.includes(one)),
  );

  keep(which: HandleSet, on: boolean): void {
    const others = this.kept.value.filter((one) => one !== which);
    this.kept.value = on ? [...others, which] : others;
  }
}
