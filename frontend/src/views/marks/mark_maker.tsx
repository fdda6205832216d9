import { useEffect, useRef, useState } from "preact/hooks";
import { arrowDirections } from "../../input/arrow_keys";
import type { Area, Point } from "../../input/flat";
import type { Vec3 } from "../../input/vec3";
import { measuringPoints, newMark, withEnd, type Mark } from "../../marks/mark";
import type { Marks } from "../../marks/marks";
import type { MarkView } from "../../marks/view";
import { clamp } from "../../scene/numbers";
import { t } from "../../texts";
import { useMeasuring } from "./use_measuring";

export interface MarkMakerProps {
  readonly marks: Marks;
  readonly view: MarkView;
  readonly area: Area;
  readonly locate: (at: Point) => Promise<Vec3 | null>;
  /** Whether the maker takes the focus, so that keys move its cross. */
  readonly focused: boolean;
}

/** Minimum length of a drag. A shorter one is a press, which creates a mark of the usual size. */
const leastDragPx = 8;
const usual: Readonly<Record<Mark["kind"], Point>> = {
  arrow: { x: -55, y: -45 },
  circle: { x: 24, y: 0 },
  text: { x: 0, y: 0 },
  ruler: { x: 0, y: 0 },
  angle: { x: 0, y: 0 },
};

/** Creates the next mark where the view is pressed. A drag sets its length or size. */
export function MarkMaker(props: MarkMakerProps) {
  const { marks, area, focused } = props;
  const button = useRef<HTMLButtonElement>(null);
  const cross = useRef<HTMLSpanElement>(null);
  const [at, setAt] = useState<Point>({ x: 0.5, y: 0.5 });
  const making = useMaking(props);
  const measuring = useMeasuring(props);
  const tool = marks.tool.value;
  const { message, begin, drag, drop } = tool !== null && tool in measuringPoints ? measuring : making;
  useEffect(() => {
    if (focused) button.current?.focus();
  }, [focused, tool]);
  useEffect(() => {
    if (!cross.current) return;
    cross.current.style.left = `${100 * at.x}%`;
    cross.current.style.top = `${100 * at.y}%`;
  });
  if (tool === null) return null;
  const key = (event: KeyboardEvent) => {
    const direction = arrowDirections[event.key];
    if (event.key === "Escape") marks.tool.value = null;
    else if (event.key === "Enter" || event.key === " ") {
      begin({ x: at.x * area.width, y: at.y * area.height });
      drop();
    } else if (direction) {
      const step = event.shiftKey ? 0.1 : 0.02;
      setAt({ x: clamp(at.x + direction[0] * step, 0, 1), y: clamp(at.y + direction[1] * step, 0, 1) });
    } else return;
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <>
      <button
        ref={button}
        type="button"
        class="picker mark-maker"
        aria-label={`${t.marks.press[tool]} ${t.settings.picture.pickKeys}`}
        onPointerDown={(event) => {
          if (event.button !== 0) return;
          event.currentTarget.setPointerCapture(event.pointerId);
          begin({ x: event.offsetX, y: event.offsetY });
        }}
        onPointerMove={(event) => drag({ x: event.offsetX, y: event.offsetY })}
        onPointerUp={drop}
        onPointerCancel={drop}
        onKeyDown={key}
      >
        <span class="picker-mark" ref={cross} aria-hidden="true" />
      </button>
      {message ? (
        <p class="glass pill mark-message" role="status">
          {message}
        </p>
      ) : null}
    </>
  );
}

/** Finds the surface at the pressed point, and then lets the end of the mark follow the drag. */
function useMaking({ marks, view, locate }: MarkMakerProps) {
  const [message, setMessage] = useState("");
  const press = useRef<{ readonly from: Point; to: Point; made: Mark | null; over: boolean } | null>(null);
  const stretch = () => {
    const { current } = press;
    if (!current?.made) return;
    const { made, from, to } = current;
    const by = { x: to.x - from.x, y: to.y - from.y };
    const end = Math.hypot(by.x, by.y) < leastDragPx ? usual[made.kind] : by;
    marks.change("make", made.id, (now) => withEnd(now, view.beside(now.place, end)));
  };
  const finish = () => {
    marks.rest();
    marks.tool.value = null;
    press.current = null;
  };
  const begin = (from: Point) => {
    const kind = marks.tool.value;
    if (kind === null || press.current) return;
    const current = { from, to: from, made: null as Mark | null, over: false };
    press.current = current;
    setMessage("");
    void locate(from).then((place) => {
      const made = place && marks.add(newMark(kind, place, marks.colour.value));
      if (!made) {
        setMessage(place ? t.marks.full : t.marks.nothingThere);
        press.current = null;
        return;
      }
      current.made = made;
      stretch();
      if (current.over) finish();
    });
  };
  const drag = (to: Point) => {
    if (!press.current || press.current.over) return;
    press.current.to = to;
    stretch();
  };
  const drop = () => {
    if (!press.current) return;
    press.current.over = true;
    if (press.current.made) finish();
  };
  return { message, begin, drag, drop };
}
