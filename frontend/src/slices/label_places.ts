import type { Area, Point } from "../input/flat";

export const lineHeight = 16;
/** Distance from the top of a line to its baseline. */
const ascent = 12;
const gap = 9;
/** Average width of digits and letters, rounded up to be safe. */
const characterWidth = 7.6;

/** The text beside a measurement, and what it stands beside: the outline of an ellipse, or a point. */
export interface Label {
  readonly lines: readonly string[];
  readonly beside: readonly Point[];
}

/** The anchor of a label's first line: where it begins, ends or has its middle. */
export interface LabelPlace {
  readonly x: number;
  readonly y: number;
  readonly anchor: "start" | "middle" | "end";
}

interface Box {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
  readonly anchor: LabelPlace["anchor"];
}

/** Returns the place of each label. Each avoids those before it as long as there is room. */
export function labelPlaces(labels: readonly Label[], area: Area): readonly LabelPlace[] {
  const taken: Box[] = [];
  return labels.map((label) => {
    const wanted = candidates(label);
    const boxes = wanted.map((box) => within(box, area));
    const isFree = (box: Box) => !taken.some((other) => overlaps(box, other));
    const found =
      wanted.map((box) => alongside(box, area)).find((box) => box !== null && isFree(box)) ??
      [...boxes, ...shifted(boxes, area)].find(isFree) ??
      boxes[0];
    if (!found) return { x: 0, y: 0, anchor: "start" };
    if (label.lines.length > 0) taken.push(found);
    const { left, top, width, anchor } = found;
    const x = anchor === "start" ? left : anchor === "end" ? left + width : left + width / 2;
    return { x, y: top + ascent, anchor };
  });
}

/** Returns the boxes to try for a label, in order of preference: right, left, above, below. */
function candidates({ lines, beside }: Label): readonly Box[] {
  const width = characterWidth * Math.max(0, ...lines.map((line) => line.length));
  const height = lineHeight * lines.length;
  const [xs, ys] = [beside.map(({ x }) => x), beside.map(({ y }) => y)];
  const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const isPoint = beside.length === 1;
  const centre = (left + right - width) / 2;
  const middle = isPoint ? top - gap - ascent : (top + bottom - height) / 2;
  return [
    { left: right + gap, top: middle, width, height, anchor: "start" },
    { left: left - gap - width, top: middle, width, height, anchor: "end" },
    { left: centre, top: top - gap - height, width, height, anchor: "middle" },
    { left: centre, top: bottom + gap, width, height, anchor: "middle" },
  ];
}

const within = (box: Box, { width, height }: Area): Box => ({
  ...box,
  left: Math.max(0, Math.min(box.left, width - box.width)),
  top: Math.max(4, Math.min(box.top, height - box.height)),
});

/**
 * Keeps a box inside the view. Returns null if that would move a label onto what it stands beside.
 */
function alongside(box: Box, area: Area): Box | null {
  const moved = within(box, area);
  return (box.anchor === "middle" ? moved.top === box.top : moved.left === box.left) ? moved : null;
}

/** Returns the same boxes, moved down and up line by line. */
function shifted(boxes: readonly Box[], area: Area): readonly Box[] {
  const steps = Math.ceil(area.height / lineHeight);
  return Array.from({ length: steps }, (_, i) => (i + 1) * lineHeight).flatMap((by) =>
    boxes.flatMap((box) => [by, -by].map((down) => within({ ...box, top: box.top + down }, area))),
  );
}

const overlaps = (a: Box, b: Box): boolean =>
  a.left < b.left + b.width && b.left < a.left + a.width && a.top < b.top + b.height && b.top < a.top + a.height;
