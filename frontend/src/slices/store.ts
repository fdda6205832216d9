import { valuesOf } from "./coding";
import { planes, type Plane } from "./stack";

export interface SliceId {
  readonly plane: Plane;
  readonly index: number;
}

/** A slice as it arrives. */
export interface Coming extends SliceId {
  readonly seq: bigint;
  readonly columns: number;
  readonly rows: number;
  readonly data: Uint8Array<ArrayBuffer>;
}

export interface StoreParts {
  /** Requests the missing slices and reports how many have arrived. */
  readonly ask: (lacking: readonly SliceId[], taken: bigint) => void;
  readonly inflate: (data: Uint8Array<ArrayBuffer>) => Promise<Uint8Array<ArrayBuffer>>;
  /** Runs `task` once before the next screen refresh. */
  readonly nextFrame: (task: () => void) => void;
  readonly received: (slice: SliceId) => void;
  /** Called for an invalid slice. */
  readonly damaged: () => void;
}

/** Limit on the voxels that are cached to show slices again without a request: a few hundred slices. */
export const mostBytes = 64 << 20;

const key = ({ plane, index }: SliceId): string => `${plane} ${index}`;

/** Requests and caches the slices on the screen. Only the newest request per plane counts. */
export class SliceStore {
  private readonly shown = new Map<Plane, number>();
  /** Cached slices, the least recently used first. */
  private readonly kept = new Map<string, Int16Array<ArrayBuffer>>();
  private readonly beingRead = new Set<string>();
  private bytes = 0;
  private taken = 0n;
  private connection = 0;
  private planned = false;

  constructor(private readonly parts: StoreParts) {}

  /** Shows a slice of a plane, or none if `index` is null. */
  show(plane: Plane, index: number | null): void {
    if (index === this.shown.get(plane)) return;
    if (index === null) this.shown.delete(plane);
    else this.shown.set(plane, index);
    if (this.lacking().length > 0) this.plan();
  }

  get(slice: SliceId): Int16Array<ArrayBuffer> | null {
    const name = key(slice);
    const values = this.kept.get(name);
    if (!values) return null;
    this.kept.delete(name);
    this.kept.set(name, values);
    return values;
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
    this.bytes = 0;
    if (this.lacking().length > 0) this.plan();
  }

  async receive(slice: Coming): Promise<void> {
    const connection = this.connection;
    this.taken = slice.seq;
    this.beingRead.add(key(slice));
    this.plan();
    try {
      const values = valuesOf(await this.parts.inflate(slice.data), slice.columns, slice.rows);
      if (connection !== this.connection) return;
      this.keep(slice, values);
      this.beingRead.delete(key(slice));
      this.parts.received({ plane: slice.plane, index: slice.index });
    } catch {
      if (connection === this.connection) this.parts.damaged(); // not requested again, because the same bytes would arrive
    }
  }

  private lacking(): SliceId[] {
    return planes.flatMap((plane) => {
      const index = this.shown.get(plane);
      if (index === undefined) return [];
      const slice = { plane, index };
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

  private keep(slice: SliceId, values: Int16Array<ArrayBuffer>): void {
    this.bytes += values.byteLength - (this.kept.get(key(slice))?.byteLength ?? 0);
    this.kept.set(key(slice), values);
    const shown = new Set([...this.shown].map(([plane, index]) => key({ plane, index })));
    for (const [name, old] of this.kept) {
      if (this.bytes <= mostBytes) break;
      if (shown.has(name) || name === key(slice)) continue;
      this.kept.delete(name);
      this.bytes -= old.byteLength;
    }
  }
}
