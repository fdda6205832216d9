import type { RefObject } from "preact";
import { useRef } from "preact/hooks";
import { arrowDirections } from "../../../input/arrow_keys";
import { directionOnBall, unitOf, type Direction } from "../../../scene/direction";
import { clamp } from "../../../scene/numbers";

/** The radius of the ball, and the margin around it, in the units of the drawing. */
export const ballRadius = 50;
export const ballMargin = 10;

export interface BallActs {
  readonly change: (direction: Direction, held: boolean) => void;
  readonly rest: () => void;
}

const wrapped = (angle: number): number => angle - 360 * Math.round(angle / 360);

/** Returns the direction after an arrow key, in degrees. With Shift, the step is longer. */
export function steppedDirection(from: Direction, key: string, shift: boolean): Direction | null {
  const arrow = arrowDirections[key];
  if (!arrow) return null;
  const step = shift ? 15 : 5;
  return { right: wrapped(from.right + step * arrow[0]), up: clamp(from.up - step * arrow[1], -90, 90) };
}

/** Moves a direction on a ball with the pointer and with keys. */
export function useBallGestures(direction: Direction, leads: boolean, { change, rest }: BallActs) {
  const svg = useRef<SVGSVGElement>(null);
  /** Whether the held light is on the back of the ball. Null while none is held. */
  const held = useRef<boolean | null>(null);
  const point = (event: PointerEvent, behind: boolean) => {
    const { x, y } = placeOnBall(svg, event);
    const to = directionOnBall(x, y, behind).direction;
    change({ right: Math.round(to.right), up: Math.round(to.up) }, true);
  };
  return {
    svg,
    grab: (event: PointerEvent) => {
      if (!leads || event.button !== 0) return;
      const at = unitOf(direction);
      const { x, y } = placeOnBall(svg, event);
      const near = Math.hypot(x - at.x, y + at.y) < 0.25;
      held.current = near && at.z < 0; // a light that is picked up on the back stays there
      svg.current?.setPointerCapture(event.pointerId);
      if (!near) point(event, false);
    },
    drag: (event: PointerEvent) => {
      if (held.current !== null) point(event, held.current);
    },
    drop: () => {
      if (held.current !== null) rest();
      held.current = null;
    },
    key: (event: KeyboardEvent) => {
      if (!leads || event.ctrlKey || event.metaKey || event.altKey) return;
      const to = steppedDirection(direction, event.key, event.shiftKey);
      if (!to) return;
      event.preventDefault();
      change(to, false);
    },
  };
}

/** Returns the position of the pointer in radii from the middle of the ball. */
function placeOnBall(svg: RefObject<SVGSVGElement | null>, event: PointerEvent) {
  const box = svg.current?.getBoundingClientRect() ?? new DOMRect();
  const scale = (ballRadius + ballMargin) / Math.max(1, box.width / 2);
  return {
    x: ((event.clientX - box.x - box.width / 2) * scale) / ballRadius,
    y: ((event.clientY - box.y - box.height / 2) * scale) / ballRadius,
  };
}
