import type { FrameTimes, Still } from "../protocol/messages";

/** A decoded tile: RGBA, opaque, rows from the top. */
export interface TilePixels {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
  readonly rgba: Uint8ClampedArray<ArrayBuffer>;
}

export interface LosslessFacts {
  readonly epoch: bigint;
  /** Samples per pixel, and the estimated relative error of the picture. */
  readonly samples: number;
  readonly error: number;
  readonly width: number;
  readonly height: number;
}

export interface LosslessAssemblerParts {
  /** Returns the tile's pixels. Rejects on a damaged tile. */
  readonly decode: (still: Still) => Promise<Uint8ClampedArray<ArrayBuffer>>;
  readonly sha256: (bytes: Uint8Array<ArrayBuffer>) => Promise<Uint8Array>;
  /** Shows all tiles of a picture at once. Returns false, and changes nothing, if they do not fit the shown picture. */
  readonly show: (tiles: readonly TilePixels[], facts: LosslessFacts) => boolean;
  /** Called if a tile does not match its hash. The streamed picture stays on the screen. */
  readonly damaged: () => void;
  readonly ack: (still: Still, times: FrameTimes, queue: number) => void;
  readonly nowMs: () => number;
}

/**
 * Assembles the lossless picture from its tiles. It checks each tile against its hash and shows all tiles together when
 * the last one has arrived, so that the picture does not change piece by piece. A newer epoch discards the tiles.
 */
export class LosslessAssembler {
  private epoch = 0n;
  private round = 0;
  private tiles = new Map<number, TilePixels>();
  private spoilt = false;
  private shown = false;
  private checking = 0;

  constructor(private readonly parts: LosslessAssemblerParts) {}

  /** Forgets all tiles, because the epochs of a new connection start again. */
  reset(): void {
    this.begin(0n);
  }

  /** Notes that something of this epoch has arrived, and discards tiles of older epochs. */
  epochIs(epoch: bigint): void {
    if (epoch > this.epoch) this.begin(epoch);
  }

  /** Whether the lossless picture of this epoch is on the screen. No compressed frame of the epoch may replace it. */
  shows(epoch: bigint): boolean {
    return this.shown && epoch === this.epoch;
  }

  async receive(still: Still): Promise<void> {
    const receivedMs = this.parts.nowMs();
    this.epochIs(still.epoch);
    const round = this.round;
    if (still.epoch < this.epoch || this.shown) {
      this.parts.ack(still, { receivedMs }, this.checking);
      return;
    }
    this.checking += 1;
    const tile = await this.checked(still);
    this.checking -= 1;
    const decoded = tile ? { decodedMs: this.parts.nowMs() } : {};
    if (round !== this.round) {
      this.parts.ack(still, { receivedMs, ...decoded }, this.checking);
      return;
    }
    if (tile) this.tiles.set(still.tile, tile);
    else if (!this.spoilt) {
      this.spoilt = true;
      this.parts.damaged();
    }
    const presented = this.complete(still) ? { presentedMs: this.parts.nowMs() } : {};
    this.parts.ack(still, { receivedMs, ...decoded, ...presented }, this.checking);
  }

  private async checked(still: Still): Promise<TilePixels | null> {
    try {
      const rgba = await this.parts.decode(still);
      if (rgba.length !== 4 * still.width * still.height) return null;
      const hash = await this.parts.sha256(rgbOf(rgba));
      const right = hash.length === still.hash.length && hash.every((byte, n) => byte === still.hash[n]);
      return right ? { x: still.x, y: still.y, width: still.width, height: still.height, rgba } : null;
    } catch {
      return null;
    }
  }

  private complete(still: Still): boolean {
    if (this.spoilt || this.tiles.size < still.tiles) return false;
    const tiles = [...this.tiles.values()];
    const width = Math.max(...tiles.map((tile) => tile.x + tile.width));
    const height = Math.max(...tiles.map((tile) => tile.y + tile.height));
    const samples = Number(still.iteration);
    this.tiles = new Map();
    const covered = tiles.reduce((area, tile) => area + tile.width * tile.height, 0) === width * height;
    this.shown = covered && this.parts.show(tiles, { epoch: still.epoch, samples, error: still.error, width, height });
    return this.shown;
  }

  private begin(epoch: bigint): void {
    this.epoch = epoch;
    this.round += 1;
    this.tiles = new Map();
    this.spoilt = false;
    this.shown = false;
  }
}

/** Returns the colours without the opacity, which is what the hash covers. */
export function rgbOf(rgba: Uint8ClampedArray<ArrayBuffer>): Uint8Array<ArrayBuffer> {
  const rgb = new Uint8Array((rgba.length / 4) * 3);
  for (let from = 0, to = 0; from < rgba.length; from += 4, to += 3) {
    rgb[to] = rgba[from] ?? 0;
    rgb[to + 1] = rgba[from + 1] ?? 0;
    rgb[to + 2] = rgba[from + 2] ?? 0;
  }
  return rgb;
}
