import { values_of } from "./coding";
import { planes, type Plane } from "./stack";

export interface SliceId {
  readonly plane: Plane;
  readonly index: number;
}

/** A slice as it comes. */
export interface Coming extends SliceId {
  readonly seq: bigint;
  readonly columns: number;
  readonly rows: number;
  readonly data: Uint8Array<ArrayBuffer>;
}

export interface StoreParts {
  /** What is lacking, and how many have come. */
  readonly ask: (lacking: readonly SliceId[], taken: bigint) => void;
  readonly inflate: (data: Uint8Array<ArrayBuffer>) => Promise<Uint8Array<ArrayBuffer>>;
  /** Runs `task` once before the next picture of the screen. */
  readonly next_frame: (task: () => void) => void;
  readonly came: (slice: SliceId) => void;
  /** One came that is none. */
  readonly damaged: () => void;
}

/** Voxels that are kept to be shown again without asking: a few hundred slices. */
export const most_bytes = 64 << 20;

const key = ({ plane, index }: SliceId): string => `${plane} ${index}`;

/** The slices that are shown, and asked for: of each plane the newest wish alone. */
export class SliceStore {
  private readonly shown_ = new Map<Plane, number>();
  /** The least recently seen first. */
  private readonly kept_ = new Map<string, Int16Array<ArrayBuffer>>();
  private readonly being_read_ = new Set<string>();
  private bytes_ = 0;
  private taken_ = 0n;
  private connection_ = 0;
  private planned_ = false;

  constructor(private readonly parts_: StoreParts) {}

  /** Null: of that plane none is shown now. */
  show(plane: Plane, index: number | null): void {
    if (index === this.shown_.get(plane)) return;
    if (index === null) this.shown_.delete(plane);
    else this.shown_.set(plane, index);
    if (this.lacking().length > 0) this.plan();
  }

  get(slice: SliceId): Int16Array<ArrayBuffer> | null {
    const name = key(slice);
    const values = this.kept_.get(name);
    if (!values) return null;
    this.kept_.delete(name);
    this.kept_.set(name, values);
    return values;
  }

  /** A new connection: numbers count anew, and what was on its way is lost. */
  connected(): void {
    this.connection_ += 1;
    this.taken_ = 0n;
    this.being_read_.clear();
    if (this.lacking().length > 0) this.plan();
  }

  /** Those that have come count no more: of another volume, or of another clip. */
  clear(): void {
    this.connection_ += 1;
    this.being_read_.clear();
    this.kept_.clear();
    this.bytes_ = 0;
    if (this.lacking().length > 0) this.plan();
  }

  async receive(slice: Coming): Promise<void> {
    const connection = this.connection_;
    this.taken_ = slice.seq;
    this.being_read_.add(key(slice));
    this.plan();
    try {
      const values = values_of(await this.parts_.inflate(slice.data), slice.columns, slice.rows);
      if (connection !== this.connection_) return;
      this.keep(slice, values);
      this.being_read_.delete(key(slice));
      this.parts_.came({ plane: slice.plane, index: slice.index });
    } catch {
      if (connection === this.connection_) this.parts_.damaged(); // not asked for again: it would come so again
    }
  }

  private lacking(): SliceId[] {
    return planes.flatMap((plane) => {
      const index = this.shown_.get(plane);
      if (index === undefined) return [];
      const slice = { plane, index };
      return this.kept_.has(key(slice)) || this.being_read_.has(key(slice)) ? [] : [slice];
    });
  }

  private plan(): void {
    if (this.planned_) return;
    this.planned_ = true;
    this.parts_.next_frame(() => {
      this.planned_ = false;
      this.parts_.ask(this.lacking(), this.taken_);
    });
  }

  private keep(slice: SliceId, values: Int16Array<ArrayBuffer>): void {
    this.kept_.set(key(slice), values);
    this.bytes_ += values.byteLength;
    const shown = new Set([...this.shown_].map(([plane, index]) => key({ plane, index })));
    for (const [name, old] of this.kept_) {
      if (this.bytes_ <= most_bytes) break;
      if (shown.has(name) || name === key(slice)) continue;
      this.kept_.delete(name);
      this.bytes_ -= old.byteLength;
    }
  }
}
