import type { Area } from "../../../input/flat";
import { perMm, pointOf, type Placing } from "../../../slices/placing";
import { interpolate, samplesOf, wholeExtentOf, type Axis, type Extent } from "../../../slices/resample";
import { pixelSize, type Stack } from "../../../slices/stack";
import { shade } from "../../../slices/window";

export interface SliceDrawing {
  readonly stack: Stack;
  /**
   * The values of the slice. Null clears the canvas, because the previous slice belongs to another
   * position.
   */
  readonly values: Int16Array | null;
  readonly table: Uint32Array;
  /** Whether values are interpolated. Otherwise, each voxel is a sharp rectangle at any zoom. */
  readonly smooth: boolean;
  readonly placing: Placing;
  /** The size of the pane in CSS pixels. */
  readonly area: Area;
}

/** Draws slices on a canvas. */
export class SliceCanvas {
  private readonly pixels = document.createElement("canvas");
  private drawn: SliceDrawing | null = null;

  draw(canvas: HTMLCanvasElement, drawing: SliceDrawing): void {
    const ratio = devicePixelRatio;
    const { stack, values, placing, area } = drawing;
    const width = Math.max(1, Math.round(area.width * ratio));
    const height = Math.max(1, Math.round(area.height * ratio));
    const before = canvas.width === width && canvas.height === height ? this.drawn : null;
    if (before && (Object.keys(drawing) as (keyof SliceDrawing)[]).every((key) => before[key] === drawing[key])) return;
    this.drawn = drawing;
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    const context = canvas.getContext("2d");
    if (!context) return;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = "#000000";
    context.fillRect(0, 0, width, height);
    if (!values) return;
    const size = pixelSize(stack);
    const scale = perMm(stack, placing, area) * ratio;
    const corner = pointOf(stack, placing, area, { column: -0.5, row: -0.5 });
    const across = { count: stack.columns, start: corner.x * ratio, scale: size.width * scale, view: width };
    const down = { count: stack.rows, start: corner.y * ratio, scale: size.height * scale, view: height };
    const [x, y] = drawing.smooth
      ? this.paintSmooth(drawing, values, across, down)
      : this.paintSharp(drawing, values, across, down);
    // A magnified smooth slice has one sample per device pixel, and the voxels of a sharp one keep their edges.
    context.imageSmoothingEnabled = Math.min(across.scale, down.scale) < 1;
    context.imageSmoothingQuality = "high";
    if (x.size > 0 && y.size > 0) context.drawImage(this.pixels, x.start, y.start, x.size, y.size);
  }

  /** Forgets what was drawn, because the pixels were lost together with the GPU context. */
  forget(): void {
    this.drawn = null;
  }

  private paintSmooth({ table }: SliceDrawing, values: Int16Array, across: Axis, down: Axis): [Extent, Extent] {
    const x = samplesOf(across);
    const y = samplesOf(down);
    this.paint(x.left.length, y.left.length, (to) => interpolate(values, across.count, x, y, table, to));
    return [x, y];
  }

  private paintSharp({ table }: SliceDrawing, values: Int16Array, across: Axis, down: Axis): [Extent, Extent] {
    this.paint(across.count, down.count, (to) => shade(values, table, to));
    return [wholeExtentOf(across), wholeExtentOf(down)];
  }

  private paint(width: number, height: number, fill: (pixels: Uint32Array) => void): void {
    this.pixels.width = width;
    this.pixels.height = height;
    const context = this.pixels.getContext("2d");
    if (!context || width === 0 || height === 0) return;
    const image = context.createImageData(width, height);
    fill(new Uint32Array(image.data.buffer));
    context.putImageData(image, 0, 0);
  }
}
