import type { RefObject } from "preact";
import { useRef } from "preact/hooks";
import { arrowDirections } from "../../../input/arrow_keys";

/** The step of an arrow key in CSS pixels. */
const keyStep = 24;

/** Handlers for the header of a window (`grab`, `move`, `drop`) and for its grip (`key`). */
export interface WindowDrag {
  readonly grab: (event: PointerEvent) => void;
  readonly move: (event: PointerEvent) => void;
  readonly drop: () => void;
  readonly key: (event: KeyboardEvent) => void;
}

/** Moves a window by its header or with arrow keys. `onMove` gets the new position of its top left corner. */
export function useWindowDrag(
  frame: RefObject<HTMLElement | null>,
  fixed: boolean,
  onMove: (x: number, y: number) => void,
): WindowDrag {
  const held = useRef<{ x: number; y: number } | null>(null);
  const corner = () => frame.current?.getBoundingClientRect() ?? new DOMRect();
  return {
    grab: (event) => {
      const target = event.currentTarget;
      if (fixed || isOnButton(event) || event.button !== 0 || !(target instanceof HTMLElement)) return;
      const { x, y } = corner();
      held.current = { x: event.clientX - x, y: event.clientY - y };
      target.setPointerCapture(event.pointerId);
    },
    move: (event) => {
      if (held.current) onMove(event.clientX - held.current.x, event.clientY - held.current.y);
    },
    drop: () => {
      held.current = null;
    },
    key: (event) => {
      const direction = arrowDirections[event.key];
      if (!direction) return;
      event.preventDefault();
      const { x, y } = corner();
      onMove(x + direction[0] * keyStep, y + direction[1] * keyStep);
    },
  };
}

/** Whether a button other than the grip was pressed. */
const isOnButton = ({ target }: PointerEvent): boolean =>
  target instanceof Element && target.closest("button") !== null && target.closest(".window-grip") === null;
