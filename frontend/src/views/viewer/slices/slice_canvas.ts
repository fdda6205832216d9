import type { Area } from "../../../input/flat";
import { perMm, pointOf, type Placing } from "../../../slices/placing";
import { interpolate, samplesOf, wholeExtentOf, type Axis, type Extent } from "../../../slices/resample";
import { pixelSize, type Grid } from "../../../slices/stack";
import type { SecondColours } from "../../../slices/second_overlay";
import type { Voxels } from "../../../slices/store";
import { shade } from "../../../slices/window";

export interface SliceDrawing {
  readonly stack: Grid;
  /**
   * The voxels of the slice. Null clears the canvas, because the previous slice belongs to another
   * position.
   */
  readonly voxels: Voxels | null;
  readonly table: Uint32Array;
  /** The colours of labels by their places. Null if they are not shown. */
  readonly labelTable: Uint32Array | null;
  readonly second: SecondColours | null;
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
    const { stack, voxels, placing, area } = drawing;
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
    if (!voxels) return;
    const { values } = voxels;
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
    this.drawSecond(context, drawing, across, down);
    this.drawLabels(context, drawing, across, down);
  }

  /** Draws the second scan over the first. */
  private drawSecond(context: CanvasRenderingContext2D, drawing: SliceDrawing, across: Axis, down: Axis): void {
    const { second } = drawing;
    const values = drawing.voxels?.second;
    if (!second || !values) return;
    context.fillStyle = `rgb(0 0 0 / ${second.dimmed})`;
    context.fillRect(0, 0, context.canvas.width, context.canvas.height);
    this.drawOver(context, across, down, drawing.smooth, (to) => shade(values, second.table, to));
  }

  /** Draws the labels over the slice. They are never interpolated, also in a smooth slice. */
  private drawLabels(context: CanvasRenderingContext2D, drawing: SliceDrawing, across: Axis, down: Axis): void {
    const { voxels, labelTable } = drawing;
    const labels = voxels?.labels;
    if (!labels || !labelTable) return;
    const fill = (to: Uint32Array) => labels.forEach((label, i) => (to[i] = labelTable[label] ?? 0));
    this.drawOver(context, across, down, false, fill);
  }

  /** Draws one pixel per voxel over what is drawn. */
  private drawOver(
    context: CanvasRenderingContext2D,
    across: Axis,
    down: Axis,
    smooth: boolean,
    fill: (pixels: Uint32Array) => void,
  ): void {
    this.paint(across.count, down.count, fill);
    const [x, y] = [wholeExtentOf(across), wholeExtentOf(down)];
    context.imageSmoothingEnabled = smooth;
    context.drawImage(this.pixels, x.start, y.start, x.size, y.size);
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
