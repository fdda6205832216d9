import type { FileMarks, MarkLabel } from "../../protocol/file_messages";
import type { Viewport } from "../../protocol/messages";
import type { ViewerSession } from "../../video/viewer_session";
import { saidOf } from "../../marks/said";
import { drawText, marginOf, textFont, type PaintedMark } from "../../marks/paint";
import { marksInPicture, unitOf } from "./in_pictures";

/** Limits of the protocol (api/proto/stream.proto). A message has at most 64 KB. */
const mostUnit = 100;
const mostFileMarks = 100;
const mostLabelPixels = 2 ** 20;
const mostPixelsOfLabels = 2 ** 24;
const mostCoverageBytes = 56_000;
/** The height of a line of text and of its part above the baseline, in font sizes. */
const lineHeight = 1.6;
const ascent = 1.2;

/**
 * Returns the marks that a worker draws into a file of this size. The worker determines which of
 * them are hidden.
 */
export async function fileMarksOf(session: ViewerSession, size: Viewport): Promise<FileMarks> {
  const unit = Math.min(mostUnit, unitOf(session.viewport, size));
  const marks = marksInPicture(session).slice(-mostFileMarks); // own marks are the last
  const most = Math.min(mostLabelPixels, mostPixelsOfLabels / Math.max(1, marks.length));
  const item = async ({ mark }: PaintedMark) => ({ mark, label: await labelOf(saidOf(mark), unit, most) });
  return { unit, items: await Promise.all(marks.map(item)) };
}

/** Draws a text for a worker, which has no fonts. A long text in a large picture is drawn smaller. */
async function labelOf(text: string, unit: number, mostPixels: number): Promise<MarkLabel | null> {
  if (text === "") return null;
  for (let scale = 1; ; scale *= 1.5) {
    const label = await labelAt(text, unit / scale, mostPixels);
    if (label) return { ...label, scale };
  }
}

/** Draws a text in this size. Returns null if the label would be too large for a message. */
async function labelAt(text: string, unit: number, mostPixels: number): Promise<Omit<MarkLabel, "scale"> | null> {
  const font = textFont(unit);
  const meter = new OffscreenCanvas(1, 1).getContext("2d");
  if (!meter) return null;
  meter.font = font.css;
  const margin = marginOf(unit);
  const width = Math.ceil(meter.measureText(text).width + 2 * margin);
  const height = Math.ceil(font.size * lineHeight);
  if (width * height > mostPixels) return null;
  const baseline = Math.round(font.size * ascent);
  const drawn = (outlined: boolean): Uint8Array => {
    const canvas = new OffscreenCanvas(width, height).getContext("2d");
    if (!canvas) return new Uint8Array(width * height);
    drawText(canvas, { text, x: margin, y: baseline }, unit, "white", outlined);
    const { data } = canvas.getImageData(0, 0, width, height);
    return Uint8Array.from({ length: width * height }, (_, i) => data[4 * i + 3] ?? 0);
  };
  const coverage = await compressed([drawn(true), drawn(false)]);
  return coverage.length > mostCoverageBytes ? null : { width, height, coverage, margin, baseline };
}

async function compressed(parts: readonly Uint8Array[]): Promise<Uint8Array<ArrayBuffer>> {
  const stream = new Blob(parts as Uint8Array<ArrayBuffer>[]).stream().pipeThrough(new CompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
