import { useEffect, useRef } from "preact/hooks";
import type { Point } from "../../input/flat";
import { noFlick } from "../../input/no_flick";
import type { Vec3 } from "../../input/vec3";
import { movedTo, withEnd, type Mark } from "../../marks/mark";
import { keyOf, type Marks } from "../../marks/marks";
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
        const end = mark.id === marks.selected.value ? endOf(mark, view, at) : null;
        return (
          <div key={mark.id}>
            <MoveHandle marks={marks} mark={mark} at={at} view={view} locate={locate} />
            {end ? <EndHandle marks={marks} mark={mark} at={end} view={view} /> : null}
          </div>
        );
      })}
    </>
  );
}

function endOf(mark: Mark, view: MarkView, at: Point): Point | null {
  if (mark.kind === "arrow") return view.pointOf(mark.tail);
  return mark.kind === "circle" ? { x: at.x + view.radiusOf(mark.place, mark.radius), y: at.y } : null;
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
      label={t.marks.moveOf(t.marks.nameOf(mark.kind, mark.text))}
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

function EndHandle({ marks, mark, at, view }: Omit<MoveHandleProps, "locate">) {
  const drag = (to: Point) =>
    marks.change("end", mark.id, (now) => {
      const from = now.kind === "circle" ? view.pointOf(now.place) : at;
      if (!from) return now;
      const start = now.kind === "circle" ? now.place : now.tail;
      return withEnd(now, view.beside(start, { x: to.x - from.x, y: to.y - from.y }));
    });
  return (
    <MarkHandle
      name={`mark-${mark.id}-end`}
      label={(mark.kind === "arrow" ? t.marks.tailOf : t.marks.edgeOf)(t.marks.nameOf(mark.kind, mark.text))}
      chosen
      at={at}
      hold={() => undefined}
      drag={drag}
      step={(right, up) => drag({ x: at.x + 2 * right, y: at.y - 2 * up })}
      rest={() => marks.rest()}
      remove={() => marks.remove(mark.id)}
    />
  );
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
