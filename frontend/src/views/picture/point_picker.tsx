import type { RefObject } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { arrowDirections } from "../../input/arrow_keys";
import type { Point } from "../../input/flat";
import { clamp } from "../../scene/numbers";
import { t } from "../../texts";
import type { InPicture } from "./in_picture";

/** Lets the user choose a point of the picture with a click, or with arrow keys and Enter. Escape cancels. */
export function PointPicker({ picture }: { readonly picture: InPicture }) {
  const picking = picture.picking.value;
  const { button, at, message, setAt, pick, end } = usePointPicker(picture);
  const mark = useMark(at);
  if (!picking) return null;
  return (
    <>
      <button
        ref={button}
        type="button"
        class="picker"
        aria-label={`${picking.label} ${t.settings.picture.pickKeys}`}
        // A click by a key has no position of its own, so it uses that of the marker.
        onClick={(event) => pick(event.detail === 0 ? at : placeOf(event, event.currentTarget))}
        onKeyDown={(event) => {
          if (event.key === "Escape") end();
          else if (arrowDirections[event.key]) setAt((from) => steppedPlace(from, event.key, event.shiftKey));
          else return;
          event.preventDefault();
          event.stopPropagation();
        }}
      >
        <span class="picker-mark" ref={mark} aria-hidden="true" />
      </button>
      <div class="glass picker-line">
        <p role="status">{message || picking.label}</p>
        <button type="button" class="button button-small" onClick={end}>
          {picking.end ?? t.settings.picture.pickEnd}
        </button>
      </div>
    </>
  );
}

/** The state of the picker. It takes the focus and restores it at the end. */
function usePointPicker(picture: InPicture) {
  const picking = picture.picking.value;
  const button = useRef<HTMLButtonElement>(null);
  const from = useRef<Element | null>(null);
  const [at, setAt] = useState<Point>({ x: 0.5, y: 0.5 });
  const [message, setMessage] = useState("");
  useEffect(() => {
    if (!picking) return;
    from.current = document.activeElement;
    setMessage("");
    button.current?.focus();
  }, [picking]);
  const end = () => {
    picture.picking.value = null;
    if (from.current instanceof HTMLElement) from.current.focus();
  };
  const pick = (place: Point) => {
    setAt(place);
    void picking?.pick(place).then((answer) => {
      if (answer === null) end();
      else setMessage(answer);
    });
  };
  return { button, at, message, setAt, pick, end };
}

/** Moves the marker with properties, because the content security policy forbids style attributes. */
function useMark(at: Point): RefObject<HTMLSpanElement | null> {
  const mark = useRef<HTMLSpanElement>(null);
  useEffect(() => {
    if (!mark.current) return;
    mark.current.style.left = `${100 * at.x}%`;
    mark.current.style.top = `${100 * at.y}%`;
  });
  return mark;
}

/** Returns the position of a click in an element, from 0 to 1. */
function placeOf(event: MouseEvent, element: Element): Point {
  const box = element.getBoundingClientRect();
  return {
    x: clamp((event.clientX - box.x) / box.width, 0, 1),
    y: clamp((event.clientY - box.y) / box.height, 0, 1),
  };
}

function steppedPlace(from: Point, key: string, far: boolean): Point {
  const [x, y] = arrowDirections[key] ?? [0, 0];
  const step = far ? 0.1 : 0.02;
  return { x: clamp(from.x + x * step, 0, 1), y: clamp(from.y + y * step, 0, 1) };
}
