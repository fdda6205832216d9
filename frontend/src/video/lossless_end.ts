import type { FrameTimes, Still } from "../protocol/messages";

/** A tile as it is to be shown: RGBA, opaque, rows from the top. */
export interface TilePixels {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
  readonly rgba: Uint8ClampedArray<ArrayBuffer>;
}

export interface LosslessFacts {
  readonly epoch: bigint;
  /** Samples a pixel, and the estimated relative error of the picture. */
  readonly samples: number;
  readonly error: number;
  readonly width: number;
  readonly height: number;
}

export interface LosslessEndParts {
  /** The tile's own pixels; rejects on a damaged one. */
  readonly decode: (still: Still) => Promise<Uint8ClampedArray<ArrayBuffer>>;
  readonly sha256: (bytes: Uint8Array<ArrayBuffer>) => Promise<Uint8Array>;
  /** All tiles of a picture at once. False: they do not fit what is shown, which stays as it is. */
  readonly show: (tiles: readonly TilePixels[], facts: LosslessFacts) => boolean;
  /** A tile was not what its hash says; the stream's picture stays. */
  readonly damaged: () => void;
  readonly ack: (still: Still, times: FrameTimes, queue: number) => void;
  readonly now_ms: () => number;
}

/**
 * The last step of a picture: its lossless tiles, each checked against its hash. They are shown together when the last
 * has come and all are right, so that nothing jumps; anything of a newer epoch forgets them.
 */
export class LosslessEnd {
  private epoch_ = 0n;
  private round_ = 0;
  private tiles_ = new Map<number, TilePixels>();
  private spoilt_ = false;
  private shown_ = false;
  private checking_ = 0;

  constructor(private readonly parts_: LosslessEndParts) {}

  /** A new connection: epochs count anew. */
  reset(): void {
    this.begin(0n);
  }

  /** Something of that epoch has come; tiles of an older one are forgotten. */
  epoch_is(epoch: bigint): void {
    if (epoch > this.epoch_) this.begin(epoch);
  }

  /** Whether the checked picture of that epoch is on the screen: then no coded frame of it may replace it. */
  shows(epoch: bigint): boolean {
    return this.shown_ && epoch === this.epoch_;
  }

  async receive(still: Still): Promise<void> {
    const received_ms = this.parts_.now_ms();
    this.epoch_is(still.epoch);
    const round = this.round_;
    if (still.epoch < this.epoch_ || this.shown_) {
      this.parts_.ack(still, { received_ms }, this.checking_);
      return;
    }
    this.checking_ += 1;
    const tile = await this.checked(still);
    this.checking_ -= 1;
    const decoded = tile ? { decoded_ms: this.parts_.now_ms() } : {};
    if (round !== this.round_) {
      this.parts_.ack(still, { received_ms, ...decoded }, this.checking_);
      return;
    }
    if (tile) this.tiles_.set(still.tile, tile);
    else if (!this.spoilt_) {
      this.spoilt_ = true;
      this.parts_.damaged();
    }
    const presented = this.complete(still) ? { presented_ms: this.parts_.now_ms() } : {};
    this.parts_.ack(still, { received_ms, ...decoded, ...presented }, this.checking_);
  }

  private async checked(still: Still): Promise<TilePixels | null> {
    try {
      const rgba = await this.parts_.decode(still);
      if (rgba.length !== 4 * still.width * still.height) return null;
      const hash = await this.parts_.sha256(rgb_of(rgba));
      const right = hash.length === still.hash.length && hash.every((byte, n) => byte === still.hash[n]);
      return right ? { x: still.x, y: still.y, width: still.width, height: still.height, rgba } : null;
    } catch {
      return null;
    }
  }

  private complete(still: Still): boolean {
    if (this.spoilt_ || this.tiles_.size < still.tiles) return false;
    const tiles = [...this.tiles_.values()];
    const width = Math.max(...tiles.map((tile) => tile.x + tile.width));
    const height = Math.max(...tiles.map((tile) => tile.y + tile.height));
    const samples = Number(still.iteration);
    this.tiles_ = new Map();
    const whole = tiles.reduce((area, tile) => area + tile.width * tile.height, 0) === width * height;
    this.shown_ = whole && this.parts_.show(tiles, { epoch: still.epoch, samples, error: still.error, width, height });
    return this.shown_;
  }

  private begin(epoch: bigint): void {
    this.epoch_ = epoch;
    this.round_ += 1;
    this.tiles_ = new Map();
    this.spoilt_ = false;
    this.shown_ = false;
  }
}

/** What the hash is of: the colours without the opacity. */
export function rgb_of(rgba: Uint8ClampedArray<ArrayBuffer>): Uint8Array<ArrayBuffer> {
  const rgb = new Uint8Array((rgba.length / 4) * 3);
  for (let from = 0, to = 0; from < rgba.length; from += 4, to += 3) {
    rgb[to] = rgba[from] ?? 0;
    rgb[to + 1] = rgba[from + 1] ?? 0;
    rgb[to + 2] = rgba[from + 2] ?? 0;
  }
  return rgb;
}
