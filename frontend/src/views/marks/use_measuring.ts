import { useEffect, useRef, useState } from "preact/hooks";
import type { Point } from "../../input/flat";
import type { Vec3 } from "../../input/vec3";
import { measuringPoints, newMark, withPointFrom, type Mark } from "../../marks/mark";
import type { Marks } from "../../marks/marks";
import { t } from "../../texts";

/** A drag of this many pixels sets two points, where it begins and ends. A shorter one is a press. */
const leastDragPx = 8;

interface MeasuringProps {
  readonly marks: Marks;
  /** Returns the surface at a point of the view, or null. */
  readonly locate: (at: Point) => Promise<Vec3 | null>;
}

interface Press {
  readonly from: Point;
  to: Point;
}

/** Sets the points of a ruler or an angle one after the other, each on the surface that is pressed. */
export function useMeasuring({ marks, locate }: MeasuringProps) {
  const [message, setMessage] = useState("");
  const press = useRef<Press | null>(null);
  const made = useRef<{ readonly id: number; readonly points: number } | null>(null);
  const tool = marks.tool.value;
  // Another tool, or none, gives up a measurement that lacks points.
  useEffect(
    () => () => {
      if (made.current) marks.remove(made.current.id);
      made.current = null;
    },
    [marks, tool],
  );
  const set = async (at: Point): Promise<void> => {
    const kind = marks.tool.value;
    const most = kind && measuringPoints[kind];
    if (!kind || !most) return;
    const place = await locate(at);
    if (!place || marks.tool.value !== kind) {
      setMessage(t.marks.nothingThere);
      return;
    }
    const before = made.current;
    const mark = before ? marks.find(before.id) : marks.add(newMark(kind, place, marks.colour.value));
    if (!mark) {
      setMessage(t.marks.full);
      return;
    }
    const points = (before?.points ?? 0) + 1;
    marks.change("make", mark.id, (now: Mark) => withPointFrom(now, points - 1, place));
    made.current = points < most ? { id: mark.id, points } : null;
    setMessage(points < most ? t.marks.nextPoint(points + 1, most) : "");
    if (points < most) return;
    marks.rest();
    marks.tool.value = null;
  };
  return {
    message,
    begin: (from: Point) => (press.current = { from, to: from }),
    drag: (to: Point) => {
      if (press.current) press.current.to = to;
    },
    drop: () => {
      const { current } = press;
      press.current = null;
      if (!current) return;
      const { from, to } = current;
      const isDrag = Math.hypot(to.x - from.x, to.y - from.y) >= leastDragPx;
      void set(from).then(() => (isDrag && made.current ? set(to) : undefined));
    },
  };
}
