import type { Viewport } from "../protocol/messages";
import type { TilePixels } from "./lossless_assembler";
import type { Picture } from "./picture";
import { pictureIn, type Rectangle } from "./picture_in";

/** The fraction of a follower's picture at its upper and lower edge that fades into the page. */
const faded = 0.08;

/**
 * Draws frames on a canvas of device pixels. A frame may be smaller while moving, or have an older shape while
 * resizing.
 */
export class Painter {
  private readonly context: CanvasRenderingContext2D;
  private fitsWindow = false;
  /** The rectangle of the shown picture on the canvas. */
  private shown: Rectangle | null = null;

  constructor(private readonly canvas: HTMLCanvasElement) {
    const context = canvas.getContext("2d", { alpha: false });
    if (!context) throw new Error("this browser gives no canvas");
    this.context = context;
    this.clear();
  }

  /**
   * Shows the presenter's whole picture, with borders, to a follower, whose canvas has another
   * shape.
   */
  fitToWindow(fitsWindow: boolean): void {
    this.fitsWindow = fitsWindow;
  }

  /** Keeps the shown picture until the first frame of the new size. */
  resize(size: Viewport): void {
    const { width, height } = this.canvas;
    if (width === size.width && height === size.height) return;
    // Excludes the borders of a follower's picture, which would shrink with each resize.
    const from = this.fitsWindow && this.shown ? this.shown : { x: 0, y: 0, width, height };
    const shown = new OffscreenCanvas(Math.max(1, Math.round(from.width)), Math.max(1, Math.round(from.height)));
    shown.getContext("2d")?.drawImage(this.canvas, -from.x, -from.y);
    this.canvas.width = size.width;
    this.canvas.height = size.height;
    if (!this.shown) this.clear();
    else if (width > 0 && height > 0) this.draw(shown, shown.width, shown.height);
  }

  paint(picture: Picture): void {
    this.draw(picture.image, picture.width, picture.height);
  }

  /**
   * Draws the tiles without scaling. Returns false, and draws nothing, if the picture does not have the size of the
   * canvas.
   */
  paintExactly(tiles: readonly TilePixels[], size: Viewport): boolean {
    if (size.width !== this.canvas.width || size.height !== this.canvas.height) return false;
    for (const { x, y, width, height, rgba } of tiles)
      this.context.putImageData(new ImageData(rgba, width, height), x, y);
    return true;
  }

  png(): Promise<Blob | null> {
    return new Promise((resolve) => this.canvas.toBlob(resolve, "image/png"));
  }

  private draw(source: CanvasImageSource, width: number, height: number): void {
    if (width === 0 || height === 0) return;
    const canvas = this.canvas;
    const place = pictureIn(canvas, { width, height }, this.fitsWindow);
    this.shown = place;
    this.context.imageSmoothingEnabled = place.width !== width || place.height !== height;
    this.context.imageSmoothingQuality = "high";
    if (place.width < canvas.width - 1 || place.height < canvas.height - 1) this.clear();
    this.context.drawImage(source, place.x, place.y, place.width, place.height);
    if (place.y > 1) this.fadeEdges(place.y, place.height);
  }

  /**
   * Returns the background of the page, which the canvas shows next to the picture. It is opaque:
   * "rgb(r, g, b)".
   */
  private ground(): string {
    return getComputedStyle(this.canvas).backgroundColor;
  }

  private clear(): void {
    this.context.fillStyle = this.ground();
    this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
  }

  /** Fades the upper and the lower edge of the picture into the page. */
  private fadeEdges(top: number, height: number): void {
    const ground = this.ground();
    const clear = ground.replace("rgb(", "rgba(").replace(")", ", 0)");
    const fade = this.context.createLinearGradient(0, top, 0, top + height);
    fade.addColorStop(0, ground);
    fade.addColorStop(faded, clear);
    fade.addColorStop(1 - faded, clear);
    fade.addColorStop(1, ground);
    this.context.fillStyle = fade;
    this.context.fillRect(0, top - 1, this.canvas.width, height + 2); // the edges may lie between two pixels
  }
}
