import type { Viewport } from "../protocol/messages";
import type { TilePixels } from "./lossless_assembler";
import type { Picture } from "./picture";

/**
 * Draws frames on a canvas of device pixels. A frame may be smaller while moving, or have an older shape while
 * resizing.
 */
export class Painter {
  private readonly context: CanvasRenderingContext2D;
  private whole = false;

  constructor(private readonly canvas: HTMLCanvasElement) {
    const context = canvas.getContext("2d", { alpha: false });
    if (!context) throw new Error("this browser gives no canvas");
    this.context = context;
  }

  /** For a follower, whose canvas has another shape: shows the presenter's whole picture, with borders. */
  showWhole(whole: boolean): void {
    this.whole = whole;
  }

  /** Keeps the shown picture until the first frame of the new size. */
  resize(size: Viewport): void {
    const { width, height } = this.canvas;
    if (width === size.width && height === size.height) return;
    const shown = new OffscreenCanvas(Math.max(1, width), Math.max(1, height));
    shown.getContext("2d")?.drawImage(this.canvas, 0, 0);
    this.canvas.width = size.width;
    this.canvas.height = size.height;
    this.draw(shown, width, height);
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

  /** The field of view is vertical, so pictures are fitted by height and centred. */
  private draw(source: CanvasImageSource, width: number, height: number): void {
    if (width === 0 || height === 0) return;
    const canvas = this.canvas;
    const fitting = (width * canvas.height) / height;
    if (this.whole && fitting > 1.02 * canvas.width) {
      const shownHeight = (height * canvas.width) / width;
      this.context.imageSmoothingEnabled = true;
      this.context.imageSmoothingQuality = "high";
      this.context.clearRect(0, 0, canvas.width, canvas.height);
      this.context.drawImage(source, 0, (canvas.height - shownHeight) / 2, canvas.width, shownHeight);
      return;
    }
    // The sides of a smaller frame are rounded to whole pixels, which does not change its shape.
    const shownWidth = Math.abs(fitting - canvas.width) < 0.02 * canvas.width ? canvas.width : fitting;
    this.context.imageSmoothingEnabled = shownWidth !== width || canvas.height !== height;
    this.context.imageSmoothingQuality = "high";
    if (shownWidth < canvas.width - 1) this.context.clearRect(0, 0, canvas.width, canvas.height);
    this.context.drawImage(source, (canvas.width - shownWidth) / 2, 0, shownWidth, canvas.height);
  }
}
