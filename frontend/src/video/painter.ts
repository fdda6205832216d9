import type { Viewport } from "../protocol/messages";
import type { TilePixels } from "./lossless_end";
import type { Picture } from "./picture";

/** Draws frames into a canvas of device pixels. A frame may be smaller (moving) or of an older shape (resizing). */
export class Painter {
  private readonly context_: CanvasRenderingContext2D;
  private whole_ = false;

  constructor(private readonly canvas_: HTMLCanvasElement) {
    const context = canvas_.getContext("2d", { alpha: false });
    if (!context) throw new Error("this browser gives no canvas");
    this.context_ = context;
  }

  /** For a follower, whose canvas has another shape: all that the presenter sees, with borders. */
  show_whole(whole: boolean): void {
    this.whole_ = whole;
  }

  /** Keeps what is shown until the first frame of the new size. */
  resize(size: Viewport): void {
    const { width, height } = this.canvas_;
    if (width === size.width && height === size.height) return;
    const shown = new OffscreenCanvas(Math.max(1, width), Math.max(1, height));
    shown.getContext("2d")?.drawImage(this.canvas_, 0, 0);
    this.canvas_.width = size.width;
    this.canvas_.height = size.height;
    this.draw(shown, width, height);
  }

  paint(picture: Picture): void {
    this.draw(picture.image, picture.width, picture.height);
  }

  /** Pixel by pixel, or not at all: false when the picture is not of the canvas's own size. */
  paint_exactly(tiles: readonly TilePixels[], size: Viewport): boolean {
    if (size.width !== this.canvas_.width || size.height !== this.canvas_.height) return false;
    for (const { x, y, width, height, rgba } of tiles) this.context_.putImageData(new ImageData(rgba, width, height), x, y);
    return true;
  }

  png(): Promise<Blob | null> {
    return new Promise((resolve) => this.canvas_.toBlob(resolve, "image/png"));
  }

  /** The field of view is a vertical one, so equal heights show equal sizes: fitted by height, about the middle. */
  private draw(source: CanvasImageSource, width: number, height: number): void {
    if (width === 0 || height === 0) return;
    const canvas = this.canvas_;
    const fitting = (width * canvas.height) / height;
    if (this.whole_ && fitting > 1.02 * canvas.width) {
      const shown_height = (height * canvas.width) / width;
      this.context_.imageSmoothingEnabled = true;
      this.context_.imageSmoothingQuality = "high";
      this.context_.clearRect(0, 0, canvas.width, canvas.height);
      this.context_.drawImage(source, 0, (canvas.height - shown_height) / 2, canvas.width, shown_height);
      return;
    }
    // A smaller frame has its sides rounded to whole pixels: that is no other shape.
    const shown_width = Math.abs(fitting - canvas.width) < 0.02 * canvas.width ? canvas.width : fitting;
    this.context_.imageSmoothingEnabled = shown_width !== width || canvas.height !== height;
    this.context_.imageSmoothingQuality = "high";
    if (shown_width < canvas.width - 1) this.context_.clearRect(0, 0, canvas.width, canvas.height);
    this.context_.drawImage(source, (canvas.width - shown_width) / 2, 0, shown_width, canvas.height);
  }
}
