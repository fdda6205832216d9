import { useEffect, useRef } from "preact/hooks";
import type { Point } from "../../input/flat";
import { noFlick } from "../../input/no_flick";
import type { Vec3 } from "../../input/vec3";
import { measuringPoints, movedTo, withEnd, type Mark } from "../../marks/mark";
import { keyOf, type Marks } from "../../marks/marks";
import { saidOf } from "../../marks/said";
import type { MarkView } from "../../marks/view";
import { t } from "../../texts";
import { useHandleGestures, useHandlePlace } from "../picture/handle_button";

export interface MarkHandlesProps {
  readonly marks: Marks;
  readonly number: number;
  readonly view: MarkView;
  /** Returns the surface or the place in the slice at a point of the view, or null. */
  readonly locate: (at: Point) => Promise<Vec3 | null>;
}

/** Delay after the last key until a mark settles on the surface. */
const settleMs = 250;

/** The handles of this viewer's marks while their window is open: one moves a mark, and one its tail or its edge. */
export function MarkHandles({ marks, number, view, locate }: MarkHandlesProps) {
  if (!marks.editing.value || !marks.shown.value || marks.tool.value !== null) return null;
  return (
    <>
      {marks.items.value.map((mark) => {
        if (!marks.isOwn(mark)) return null;
        const at = view.lookOf(mark, keyOf(number, mark.id)) === "none" ? null : view.pointOf(mark.place);
        if (!at) return null;
        const ends = mark.id === marks.selected.value ? endsOf(mark, view, at) : [];
        return (
          <div key={mark.id}>
            <MoveHandle marks={marks} mark={mark} at={at} view={view} locate={locate} />
            {ends.map((end) => (
              <EndHandle key={end.part} marks={marks} mark={mark} {...end} view={view} locate={locate} />
            ))}
          </div>
        );
      })}
    </>
  );
}

/** A handle beside that of the place: a tail, the edge of a circle, or the second side of an angle. */
interface End {
  readonly part: "end" | "side";
  readonly at: Point;
}

function endsOf(mark: Mark, view: MarkView, at: Point): readonly End[] {
  if (mark.kind === "circle")
    return [{ part: "end", at: { x: at.x + view.radiusOf(mark.place, mark.radius), y: at.y } }];
  const tail = mark.kind === "text" ? null : view.pointOf(mark.tail);
  const side = mark.kind === "angle" ? view.pointOf(mark.end) : null;
  return [
    ...(tail ? [{ part: "end" as const, at: tail }] : []),
    ...(side ? [{ part: "side" as const, at: side }] : []),
  ];
}

interface MoveHandleProps extends Omit<MarkHandlesProps, "number"> {
  readonly mark: Mark;
  readonly at: Point;
}

function MoveHandle({ marks, mark, at, view, locate }: MoveHandleProps) {
  const newest = useRef(at);
  const settling = useRef<ReturnType<typeof setTimeout> | undefined>(undefined);
  useEffect(() => () => clearTimeout(settling.current), []);
  const drag = (to: Point) => {
    newest.current = to;
    marks.change("move", mark.id, (now) => movedTo(now, view.beside(now.place, { x: to.x - at.x, y: to.y - at.y })));
  };
  const settle = () => {
    void locate(newest.current).then((place) => {
      if (place) marks.change("move", mark.id, (now) => movedTo(now, place));
      marks.rest();
    });
  };
  return (
    <MarkHandle
      name={`mark-${mark.id}`}
      label={t.marks.moveOf(t.marks.nameOf(mark.kind, saidOf(mark)))}
      chosen={marks.selected.value === mark.id}
      at={at}
      hold={() => (marks.selected.value = mark.id)}
      drag={drag}
      step={(right, up) => {
        drag({ x: at.x + 2 * right, y: at.y - 2 * up });
        clearTimeout(settling.current);
        settling.current = setTimeout(settle, settleMs);
      }}
      rest={settle}
      remove={() => marks.remove(mark.id)}
    />
  );
}

function EndHandle({ marks, mark, at, view, locate, part }: MoveHandleProps & Pick<End, "part">) {
  const newest = useRef(at);
  const settling = useRef<ReturnType<typeof setTimeout> | undefined>(undefined);
  useEffect(() => () => clearTimeout(settling.current), []);
  const put = (now: Mark, place: Vec3): Mark => (part === "side" ? { ...now, end: place } : withEnd(now, place));
  const drag = (to: Point) => {
    newest.current = to;
    marks.change(part, mark.id, (now) => {
      const from = now.kind === "circle" ? view.pointOf(now.place) : at;
      if (!from) return now;
      const start = now.kind === "circle" ? now.place : part === "side" ? now.end : now.tail;
      return put(now, view.beside(start, { x: to.x - from.x, y: to.y - from.y }));
    });
  };
  // The points of a measurement lie on the surface, and those of an arrow or a circle anywhere.
  const settle = () => {
    if (!(mark.kind in measuringPoints)) {
      marks.rest();
      return;
    }
    void locate(newest.current).then((place) => {
      if (place) marks.change(part, mark.id, (now) => put(now, place));
      marks.rest();
    });
  };
  return (
    <MarkHandle
      name={`mark-${mark.id}-${part}`}
      label={endLabel(mark, part)}
      chosen
      at={at}
      hold={() => undefined}
      drag={drag}
      step={(right, up) => {
        drag({ x: at.x + 2 * right, y: at.y - 2 * up });
        clearTimeout(settling.current);
        settling.current = setTimeout(settle, settleMs);
      }}
      rest={settle}
      remove={() => marks.remove(mark.id)}
    />
  );
}

function endLabel(mark: Mark, part: End["part"]): string {
  const name = t.marks.nameOf(mark.kind, saidOf(mark));
  if (mark.kind in measuringPoints) return (part === "side" ? t.marks.thirdOf : t.marks.secondOf)(name);
  return (mark.kind === "arrow" ? t.marks.tailOf : t.marks.edgeOf)(name);
}

interface MarkHandleProps {
  readonly name: string;
  readonly label: string;
  readonly chosen: boolean;
  readonly at: Point;
  readonly hold: () => void;
  readonly drag: (to: Point) => void;
  readonly step: (right: number, up: number) => void;
  readonly rest: () => void;
  readonly remove: () => void;
}

function MarkHandle(props: MarkHandleProps) {
  const { name, label, chosen, at, hold, remove } = props;
  const button = useHandlePlace(at);
  const gestures = useHandleGestures(props);
  return (
    <button
      ref={button}
      type="button"
      class="handle mark-handle"
      data-handle={name}
      data-chosen={chosen ? "" : undefined}
      aria-label={label}
      aria-pressed={chosen}
      onFocus={hold}
      onTouchMove={noFlick}
      onPointerDown={(event) => gestures.grab(event, event.currentTarget)}
      onPointerMove={gestures.move}
      onPointerUp={gestures.drop}
      onPointerCancel={gestures.drop}
      onKeyDown={(event) => {
        if (event.key !== "Delete" && event.key !== "Backspace") {
          gestures.key(event);
          return;
        }
        event.preventDefault();
        event.stopPropagation();
        remove();
      }}
    />
  );
}
