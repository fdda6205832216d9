import type { Area } from "../../../input/flat";
import { perMm, pointOf, type Placing } from "../../../slices/placing";
import { pixelSize, type Stack } from "../../../slices/stack";
import { shade } from "../../../slices/window";

/** Draws slices on a canvas. Each voxel is a sharp rectangle at any zoom. */
export class SliceCanvas {
  private readonly pixels = document.createElement("canvas");
  private values: Int16Array | null = null;
  private table: Uint32Array | null = null;

  /**
   * `area` is in CSS pixels. With null values, clears the canvas, because the previous slice belongs to another
   * position.
   */
  draw(
    canvas: HTMLCanvasElement,
    stack: Stack,
    values: Int16Array | null,
    table: Uint32Array,
    placing: Placing,
    area: Area,
  ): void {
    const ratio = devicePixelRatio;
    const width = Math.max(1, Math.round(area.width * ratio));
    const height = Math.max(1, Math.round(area.height * ratio));
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    const context = canvas.getContext("2d");
    if (!context) return;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = "#000000";
    context.fillRect(0, 0, width, height);
    if (!values) return;
    this.shade(stack, values, table);
    const size = pixelSize(stack);
    const mm = perMm(stack, placing, area);
    const corner = pointOf(stack, placing, area, { column: -0.5, row: -0.5 });
    context.imageSmoothingEnabled = Math.min(size.width, size.height) * mm * ratio < 1;
    context.imageSmoothingQuality = "high";
    context.drawImage(
      this.pixels,
      corner.x * ratio,
      corner.y * ratio,
      stack.columns * size.width * mm * ratio,
      stack.rows * size.height * mm * ratio,
    );
  }

  /** The pixels were lost together with the GPU context. */
  forget(): void {
    this.values = null;
  }

  private shade(stack: Stack, values: Int16Array, table: Uint32Array): void {
    if (values === this.values && table === this.table) return;
    this.values = values;
    this.table = table;
    this.pixels.width = stack.columns;
    this.pixels.height = stack.rows;
    const context = this.pixels.getContext("2d");
    if (!context) return;
    const image = context.createImageData(stack.columns, stack.rows);
    shade(values, table, new Uint32Array(image.data.buffer));
    context.putImageData(image, 0, 0);
  }
}
