import type { Point } from "../../input/flat";
import { no_flick } from "../../input/no_flick";
import { useLayoutEffect, useRef } from "preact/hooks";

export interface HandleButtonProps {
  readonly name: string;
  readonly label: string;
  readonly look: "face" | "plane" | "tilt" | "light";
  readonly behind?: boolean;
  /** Where it is in its area, in pixels. */
  readonly at: Point;
  /** As a slider. */
  readonly low: number;
  readonly high: number;
  readonly now: number;
  readonly said: string;
  readonly grab?: () => void;
  /** The hand has it there now. */
  readonly drag: (to: Point) => void;
  readonly step: (right: number, up: number) => void;
  readonly rest: () => void;
  readonly hold: (held: boolean) => void;
}

const ways: Readonly<Record<string, readonly [number, number]>> = {
  ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1], PageUp: [0, 10], PageDown: [0, -10],
};

/** What a hand takes hold of over a picture; arrow keys move it, with Shift ten times as far. */
export function HandleButton({ name, label, look, behind = false, at, low, high, now, said, grab, drag, step, rest, hold }: HandleButtonProps) {
  const button = useRef<HTMLButtonElement>(null);
  /** From where the hand took hold to the handle's middle. */
  const held = useRef<Point | null>(null);
  useLayoutEffect(() => {
    // By a property, which the content security policy allows.
    if (button.current) button.current.style.transform = `translate(${Math.round(at.x)}px, ${Math.round(at.y)}px) translate(-50%, -50%)`;
  }, [at.x, at.y]);
  const dropped = () => {
    if (held.current) rest();
    held.current = null;
  };
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
      aria-valuetext={said}
      onFocus={() => hold(true)}
      onBlur={() => hold(false)}
      onTouchMove={no_flick}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.preventDefault();
        event.currentTarget.focus();
        event.currentTarget.setPointerCapture(event.pointerId);
        held.current = { x: at.x - event.clientX, y: at.y - event.clientY };
        grab?.();
      }}
      onPointerMove={(event) => {
        if (held.current) drag({ x: event.clientX + held.current.x, y: event.clientY + held.current.y });
      }}
      onPointerUp={dropped}
      onPointerCancel={dropped}
      onKeyDown={(event) => {
        const way = ways[event.key];
        if (!way || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        event.stopPropagation();
        const by = event.shiftKey ? 10 : 1;
        step(way[0] * by, way[1] * by);
      }}
    />
  );
}
