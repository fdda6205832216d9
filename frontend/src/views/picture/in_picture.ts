import type { Point } from "../../input/flat";
import { computed, signal } from "@preact/signals";

/** The windows whose things can be taken hold of in the picture. */
export type HandleSet = "cuts" | "light";

/** Somebody is asked for a place of the picture, from 0 to 1 from its upper left; answers what to say, or nothing when it is done. */
export interface Picking {
  readonly label: string;
  readonly pick: (at: Point) => Promise<string | null>;
}

/** What of the windows lies on the picture: theirs while they are open, and what is to stay. */
export class InPicture {
  readonly open = signal<readonly HandleSet[]>([]);
  readonly kept = signal<readonly HandleSet[]>([]);
  readonly picking = signal<Picking | null>(null);
  /** Which light the light window shows. */
  readonly light = signal(0);
  readonly shown = computed<readonly HandleSet[]>(() =>
    (["cuts", "light"] as const).filter((one) => this.open.value.includes(one) || this.kept.value.includes(one)),
  );

  keep(which: HandleSet, on: boolean): void {
    const others = this.kept.value.filter((one) => one !== which);
    this.kept.value = on ? [...others, which] : others;
  }
}
