import type { Area, Point } from "../input/flat";
import type { Mark } from "./mark";
import { shapesOf, type Shapes } from "./shapes";
import type { Look, MarkView } from "./view";

/** The colours of style/picture.css. */
const colours = ["#ffb454", "#6ecbff", "#f59ac8", "#8fe08a", "#f6e05e", "#c3a6ff", "#63e0cf", "#ff9480"];
const dark = "#14181d";

type Canvas = CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D;

export interface PaintedMark {
  readonly mark: Mark;
  readonly key: string;
}

/** Draws marks on a saved picture as the page shows them. `unit` is the size of a pixel of the page. */
export function paintMarks(
  canvas: Canvas,
  marks: readonly PaintedMark[],
  view: MarkView,
  area: Area,
  unit: number,
): void {
  for (const { mark, key } of marks) {
    const look = view.lookOf(mark, key);
    const shapes = look === "none" ? null : shapesOf(mark, view, area, unit);
    if (shapes) paint(canvas, shapes, colours[mark.colour] ?? dark, look, unit);
  }
}

function paint(canvas: Canvas, shapes: Shapes, colour: string, look: Look, unit: number): void {
  canvas.save();
  canvas.globalAlpha = look === "faint" ? 0.5 : 1;
  canvas.lineCap = "round";
  canvas.lineJoin = "round";
  strokes(canvas, shapes, dark, 5.5 * unit);
  if (look === "faint") canvas.setLineDash([5 * unit, 5 * unit]);
  strokes(canvas, shapes, colour, 2.5 * unit);
  canvas.setLineDash([]);
  if (shapes.text?.said) {
    const { at, anchor, said } = shapes.text;
    canvas.textAlign = anchor === "middle" ? "center" : anchor;
    const text = { text: said, ...at };
    drawText(canvas, text, unit, dark, true);
    drawText(canvas, text, unit, colour, false);
  }
  canvas.restore();
}

interface PlacedText extends Point {
  readonly text: string;
}

const outline = 4;
/** Returns the space beside a text that its outline needs. */
export const marginOf = (unit: number): number => Math.ceil((outline / 2 + 1) * unit);

export function textFont(unit: number): { readonly css: string; readonly size: number } {
  const size = 15 * unit;
  return { css: `640 ${size}px system-ui, sans-serif`, size };
}

/** Draws a text, or its outline. */
export function drawText(canvas: Canvas, at: PlacedText, unit: number, colour: string, outlined: boolean): void {
  canvas.font = textFont(unit).css;
  canvas.direction = "ltr";
  canvas.lineJoin = "round";
  canvas.lineWidth = outline * unit;
  canvas.strokeStyle = colour;
  canvas.fillStyle = colour;
  if (outlined) canvas.strokeText(at.text, at.x, at.y);
  else canvas.fillText(at.text, at.x, at.y);
}

function strokes(canvas: Canvas, { lines, head, circle, dots }: Shapes, colour: string, width: number): void {
  canvas.strokeStyle = colour;
  canvas.fillStyle = colour;
  canvas.lineWidth = width;
  canvas.beginPath();
  for (const [from, to] of lines) {
    canvas.moveTo(from.x, from.y);
    canvas.lineTo(to.x, to.y);
  }
  if (circle) {
    canvas.moveTo(circle.at.x + circle.radius, circle.at.y);
    canvas.arc(circle.at.x, circle.at.y, circle.radius, 0, 2 * Math.PI);
  }
  canvas.stroke();
  if (head.length > 0) filled(canvas, head);
  for (const { x, y } of dots) {
    canvas.beginPath();
    canvas.arc(x, y, width, 0, 2 * Math.PI);
    canvas.fill();
  }
}

function filled(canvas: Canvas, points: readonly Point[]): void {
  canvas.beginPath();
  for (const { x, y } of points) canvas.lineTo(x, y);
  canvas.closePath();
  canvas.fill();
  canvas.stroke();
}
