import type { Point } from "../../input/flat";
import { noFlick } from "../../input/no_flick";
import { useLayoutEffect, useRef } from "preact/hooks";

export interface HandleButtonProps {
  readonly name: string;
  readonly label: string;
  readonly look: "face" | "plane" | "tilt" | "light";
  readonly behind?: boolean;
  /** Position of the handle in its area, in pixels. */
  readonly at: Point;
  /** The values of the handle as a slider. */
  readonly low: number;
  readonly high: number;
  readonly now: number;
  readonly valueText: string;
  readonly grab?: () => void;
  /** Called with the position to which the handle is dragged. */
  readonly drag: (to: Point) => void;
  readonly step: (right: number, up: number) => void;
  readonly rest: () => void;
  readonly hold: (held: boolean) => void;
}

/** Steps to the right and up. */
const keySteps: Readonly<Record<string, readonly [right: number, up: number]>> = {
  ArrowRight: [1, 0],
  ArrowLeft: [-1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
  PageUp: [0, 10],
  PageDown: [0, -10],
};

/** A handle over a picture. Arrow keys move it, and with Shift ten times as far. */
export function HandleButton(props: HandleButtonProps) {
  const { name, label, look, behind = false, at, low, high, now, valueText, hold } = props;
  const button = useHandlePlace(at);
  const gestures = useHandleGestures(props);
  return (
    <button
      ref={button}
      type="button"
      class="handle"
      role="slider"
      data-handle={name}
      data-look={look}
      data-behind={behind ? "" : undefined}
      aria-label={label}
      aria-valuemin={Math.round(low)}
      aria-valuemax={Math.round(high)}
      aria-valuenow={Math.round(now)}
      aria-valuetext={valueText}
      onFocus={() => hold(true)}
      onBlur={() => hold(false)}
      onTouchMove={noFlick}
      onPointerDown={(event) => gestures.grab(event, event.currentTarget)}
      onPointerMove={gestures.move}
      onPointerUp={gestures.drop}
      onPointerCancel={gestures.drop}
      onKeyDown={gestures.key}
    />
  );
}

/** Returns the reference of a button whose middle is kept at a place of its area, in pixels. */
export function useHandlePlace(at: Point) {
  const button = useRef<HTMLButtonElement>(null);
  useLayoutEffect(() => {
    // The content security policy forbids style attributes, but not properties.
    if (button.current)
      button.current.style.transform = `translate(${Math.round(at.x)}px, ${Math.round(at.y)}px) translate(-50%, -50%)`;
  }, [at.x, at.y]);
  return button;
}

type HandleGestures = Pick<HandleButtonProps, "at" | "grab" | "drag" | "step" | "rest">;

/** Drags a handle, and moves it by keys. */
export function useHandleGestures({ at, grab, drag, step, rest }: HandleGestures) {
  /** The offset from the pointer to the middle of the handle while it is held. */
  const held = useRef<Point | null>(null);
  return {
    grab: (event: PointerEvent, element: HTMLElement) => {
      if (event.button !== 0) return;
      event.preventDefault();
      element.focus();
      element.setPointerCapture(event.pointerId);
      held.current = { x: at.x - event.clientX, y: at.y - event.clientY };
      grab?.();
    },
    move: (event: PointerEvent) => {
      if (held.current) drag({ x: event.clientX + held.current.x, y: event.clientY + held.current.y });
    },
    drop: () => {
      if (held.current) rest();
      held.current = null;
    },
    key: (event: KeyboardEvent) => {
      const steps = keySteps[event.key];
      if (!steps || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation();
      const by = event.shiftKey ? 10 : 1;
      step(steps[0] * by, steps[1] * by);
    },
  };
}
