import { labelsOf, valuesOf } from "./coding";
import type { CurvedSlice } from "./curve_view";
import { planes, type Plane, type Stack } from "./stack";

/** What a slice shows: a plane, or the surface along the curve. */
const cuts = [...planes, "curve"] as const;
export type Cut = (typeof cuts)[number];

export interface SliceId {
  readonly plane: Cut;
  readonly index: number;
  /** `Oblique.id` or `CurvedSlice.id`. Absent for a stored slice. */
  readonly oblique?: number | undefined;
}

/** A slice that is requested. The stack says where an oblique one lies, and `curved` where one along the curve does. */
export interface WantedSlice extends SliceId {
  readonly stack?: Stack | undefined;
  readonly curved?: CurvedSlice;
}

/** A slice as it arrives. */
export interface Coming extends SliceId {
  readonly seq: bigint;
  readonly columns: number;
  readonly rows: number;
  readonly data: Uint8Array<ArrayBuffer>;
  /** The values of the second scan, if the session has one. */
  readonly second?: Uint8Array<ArrayBuffer>;
  /** The places of the pixels' labels. Absent if no pixel has one. */
  readonly labels?: Uint8Array<ArrayBuffer>;
}

export interface Voxels {
  readonly values: Int16Array<ArrayBuffer>;
  /** The values of the second scan at the same pixels, or null if there is none. */
  readonly second: Int16Array<ArrayBuffer> | null;
  /** The place of each voxel's label in the list of labels, from 1, or null if none has one. */
  readonly labels: Uint8Array<ArrayBuffer> | null;
}

const bytesOf = (voxels: Voxels | undefined): number =>
  voxels ? voxels.values.byteLength + (voxels.second?.byteLength ?? 0) + (voxels.labels?.byteLength ?? 0) : 0;

export interface StoreParts {
  /** Requests the missing slices and reports how many have arrived. */
  readonly ask: (lacking: readonly WantedSlice[], taken: bigint) => void;
  readonly inflate: (data: Uint8Array<ArrayBuffer>) => Promise<Uint8Array<ArrayBuffer>>;
  /** Runs `task` once before the next screen refresh. */
  readonly nextFrame: (task: () => void) => void;
  readonly received: (slice: SliceId) => void;
  /** Called for an invalid slice. */
  readonly damaged: () => void;
}

/** Limit on the voxels that are cached to show slices again without a request: a few hundred slices. */
export const mostBytes = 64 << 20;

const key = ({ plane, index, oblique }: SliceId): string => `${plane} ${index} ${oblique ?? 0}`;

/** Requests and caches the slices on the screen. Only the newest request per plane counts. */
export class SliceStore {
  private readonly shown = new Map<Cut, WantedSlice>();
  /** The newest resampled slice of each plane and of the curve. */
  private readonly newest = new Map<Cut, Voxels>();
  /** Cached slices, the least recently used first. */
  private readonly kept = new Map<string, Voxels>();
  private readonly beingRead = new Set<string>();
  private bytes = 0;
  private taken = 0n;
  private connection = 0;
  private planned = false;

  constructor(private readonly parts: StoreParts) {}

  /** Shows a slice of a plane, or none if `index` is null. */
  show(plane: Plane, index: number | null, stack?: Stack): void {
    this.replace(plane, index === null ? undefined : { plane, index, oblique: stack?.oblique?.id, stack });
  }

  /** Shows the slice along the curve, or none. */
  showCurved(curved: CurvedSlice | null): void {
    this.replace("curve", curved ? { plane: "curve", index: 0, oblique: curved.id, curved } : undefined);
  }

  private replace(plane: Cut, slice: WantedSlice | undefined): void {
    const before = this.shown.get(plane);
    if (before?.index === slice?.index && before?.oblique === slice?.oblique) return;
    if (slice) this.shown.set(plane, slice);
    else this.shown.delete(plane);
    if (!slice?.oblique) this.newest.delete(plane);
    if (this.lacking().length > 0) this.plan();
  }

  get(slice: SliceId): Voxels | null {
    const name = key(slice);
    const voxels = this.kept.get(name);
    if (!voxels) return null;
    this.kept.delete(name);
    this.kept.set(name, voxels);
    return voxels;
  }

  /**
   * Returns the newest resampled slice of a plane or of the curve, which is shown until the next one arrives, so that a
   * view that is turned does not flicker.
   */
  newestOblique(plane: Cut, pixels: number): Voxels | null {
    const voxels = this.newest.get(plane);
    return voxels?.values.length === pixels ? voxels : null;
  }

  /** Notes a new connection, on which sequence numbers restart. Slices in transit are lost. */
  connected(): void {
    this.connection += 1;
    this.taken = 0n;
    this.beingRead.clear();
    if (this.lacking().length > 0) this.plan();
  }

  /** Discards all slices, because the volume or the clip has changed. */
  clear(): void {
    this.connection += 1;
    this.beingRead.clear();
    this.kept.clear();
    this.newest.clear();
    this.bytes = 0;
    if (this.lacking().length > 0) this.plan();
  }

  async receive(slice: Coming): Promise<void> {
    const connection = this.connection;
    this.taken = slice.seq;
    this.beingRead.add(key(slice));
    this.plan();
    try {
      const { columns, rows } = slice;
      const values = valuesOf(await this.parts.inflate(slice.data), columns, rows);
      const second = slice.second ? valuesOf(await this.parts.inflate(slice.second), columns, rows) : null;
      const labels = slice.labels ? labelsOf(await this.parts.inflate(slice.labels), columns, rows) : null;
      if (connection !== this.connection) return;
      this.keep(slice, { values, second, labels });
      this.beingRead.delete(key(slice));
      this.parts.received({ plane: slice.plane, index: slice.index });
    } catch {
      if (connection === this.connection) this.parts.damaged(); // not requested again, because the same bytes would arrive
    }
  }

  private lacking(): WantedSlice[] {
    return cuts.flatMap((plane) => {
      const slice = this.shown.get(plane);
      if (!slice) return [];
      return this.kept.has(key(slice)) || this.beingRead.has(key(slice)) ? [] : [slice];
    });
  }

  private plan(): void {
    if (this.planned) return;
    this.planned = true;
    this.parts.nextFrame(() => {
      this.planned = false;
      this.parts.ask(this.lacking(), this.taken);
    });
  }

  private keep(slice: SliceId, voxels: Voxels): void {
    this.bytes += bytesOf(voxels) - bytesOf(this.kept.get(key(slice)));
    this.kept.set(key(slice), voxels);
    if (slice.oblique) this.newest.set(slice.plane, voxels);
    const shown = new Set([...this.shown.values()].map(key));
    for (const [name, old] of this.kept) {
      if (this.bytes <= mostBytes) break;
      if (shown.has(name) || name === key(slice)) continue;
      this.kept.delete(name);
      this.bytes -= bytesOf(old);
    }
  }
}
