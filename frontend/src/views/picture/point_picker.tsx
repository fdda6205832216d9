import type { Point } from "../../input/flat";
import { useEffect, useRef, useState } from "preact/hooks";
import { clamp } from "../../scene/numbers";
import { t } from "../../texts";
import type { InPicture } from "./in_picture";

const ways: Readonly<Record<string, readonly [number, number]>> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** Asks for a place of the picture: pressed there, or a mark moved by arrow keys and taken with Enter. Escape ends it. */
export function PointPicker({ picture }: { readonly picture: InPicture }) {
  const picking = picture.picking.value;
  const button = useRef<HTMLButtonElement>(null);
  const mark = useRef<HTMLSpanElement>(null);
  const from = useRef<Element | null>(null);
  const [at, set_at] = useState<Point>({ x: 0.5, y: 0.5 });
  const [said, set_said] = useState("");
  useEffect(() => {
    if (!picking) return;
    from.current = document.activeElement;
    set_said("");
    button.current?.focus();
  }, [picking]);
  useEffect(() => {
    if (!mark.current) return;
    mark.current.style.left = `${100 * at.x}%`;
    mark.current.style.top = `${100 * at.y}%`;
  });
  if (!picking) return null;
  const end = () => {
    picture.picking.value = null;
    if (from.current instanceof HTMLElement) from.current.focus();
  };
  const take = (place: Point) => {
    set_at(place);
    void picking.pick(place).then((answer) => {
      if (answer === null) end();
      else set_said(answer);
    });
  };
  return (
    <>
      <button ref={button} type="button" class="picker" aria-label={`${picking.label} ${t.settings.picture.pick_keys}`}
        onClick={(event) => {
          const box = event.currentTarget.getBoundingClientRect();
          // Of a press by keys nobody says where.
          if (event.detail === 0) take(at);
          else take({ x: clamp((event.clientX - box.x) / box.width, 0, 1), y: clamp((event.clientY - box.y) / box.height, 0, 1) });
        }}
        onKeyDown={(event) => {
          const way = ways[event.key];
          if (event.key === "Escape") end();
          else if (way) set_at(({ x, y }) => ({ x: clamp(x + way[0] * (event.shiftKey ? 0.1 : 0.02), 0, 1), y: clamp(y + way[1] * (event.shiftKey ? 0.1 : 0.02), 0, 1) }));
          else return;
          event.preventDefault();
          event.stopPropagation();
        }}>
        <span class="picker-mark" ref={mark} aria-hidden="true" />
      </button>
      <div class="glass picker-line">
        <p role="status">{said || picking.label}</p>
        <button type="button" class="button button-small" onClick={end}>{t.settings.picture.pick_end}</button>
      </div>
    </>
  );
}
