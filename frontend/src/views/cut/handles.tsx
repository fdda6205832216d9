import { useEffect, useRef, useState } from "preact/hooks";
import type { CameraPose } from "../../input/camera";
import { corners, dragged, edges, handles_to_take, moved, on_screen, plane_in_box, range_of, type Box, type Handle, type PlacedHandle, type Region } from "../../cut/region";
import { t } from "../../texts/en";

export const name_of = (handle: Handle): string => (handle.kind === "plane" ? t.cut.plane : t.cut.faces[handle.axis][handle.side]);
export const key_of = (handle: Handle): string => (handle.kind === "plane" ? "plane" : `${handle.axis}-${handle.side}`);

export interface HandlesProps {
  readonly pose: CameraPose;
  readonly region: Region;
  readonly bounds: Box;
  readonly change: (region: Region, rest: boolean) => void;
}

/** The box and the plane over the picture, with a handle for each of their faces. */
export function Handles({ pose, region, bounds, change }: HandlesProps) {
  const area = useRef<HTMLDivElement>(null);
  const [held, set_held] = useState<Handle | null>(null);
  const [screen, set_screen] = useState({ width: 1, height: 1 });
  useEffect(() => {
    const element = area.current;
    if (!element) return;
    const measure = () => set_screen({ width: Math.max(1, element.clientWidth), height: Math.max(1, element.clientHeight) });
    measure();
    const watching = new ResizeObserver(measure);
    watching.observe(element);
    return () => watching.disconnect();
  }, []);
  const at = (place: Parameters<typeof on_screen>[2]) => on_screen(pose, screen, place);
  const box = corners(region).map(at);
  const plane = plane_in_box(region).map(at).flatMap((p) => (p ? [`${p.x},${p.y}`] : []));
  return (
    <div class="cut-area" ref={area} role="region" aria-label={t.cut.area}>
      <svg aria-hidden="true" width={screen.width} height={screen.height}>
        {edges.map(([a, b]) => {
          const from = box[a], to = box[b];
          return from && to ? <line key={`${a}-${b}`} x1={from.x} y1={from.y} x2={to.x} y2={to.y} /> : null;
        })}
        {plane.length > 2 ? <polygon points={plane.join(" ")} /> : null}
      </svg>
      {handles_to_take(pose, screen, region, held).map((placed) => (
        <One key={key_of(placed.handle)} placed={placed} pose={pose} region={region} bounds={bounds} change={change} screen={screen} hold={set_held} />
      ))}
    </div>
  );
}

interface OneProps extends HandlesProps {
  readonly placed: PlacedHandle;
  readonly screen: { readonly width: number; readonly height: number };
  readonly hold: (handle: Handle | null) => void;
}

function One({ placed, pose, region, bounds, change, screen, hold }: OneProps) {
  const { handle, place, along, x, y } = placed;
  const button = useRef<HTMLButtonElement>(null);
  const held = useRef<{ x: number; y: number; at: number } | null>(null);
  useEffect(() => {
    // By a property, which the content security policy allows.
    if (button.current) button.current.style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px) translate(-50%, -50%)`;
  });
  const range = range_of(handle, region, bounds);
  const step = (by: number) => change(moved(handle, range.at + by, region, bounds), true);
  return (
    <button
      ref={button}
      type="button"
      class="cut-handle"
      role="slider"
      data-handle={key_of(handle)}
      data-plane={handle.kind === "plane" ? "" : undefined}
      aria-label={name_of(handle)}
      aria-valuemin={Math.round(range.low)}
      aria-valuemax={Math.round(range.high)}
      aria-valuenow={Math.round(range.at)}
      aria-valuetext={t.cut.mm(Math.round(range.at))}
      onFocus={() => hold(handle)}
      onBlur={() => hold(null)}
      onPointerDown={(event) => {
        event.preventDefault();
        event.currentTarget.focus();
        event.currentTarget.setPointerCapture(event.pointerId);
        held.current = { x: event.clientX, y: event.clientY, at: range.at };
      }}
      onPointerMove={(event) => {
        const start = held.current;
        if (!start) return;
        const by = dragged(pose, screen, place, along, { x: event.clientX - start.x, y: event.clientY - start.y });
        if (by === null) return;
        const next = moved(handle, start.at + by, region, bounds);
        change(next, false);
        // From here on: its place in the picture has moved along.
        held.current = { x: event.clientX, y: event.clientY, at: range_of(handle, next, bounds).at };
      }}
      onPointerUp={() => {
        if (held.current) change(region, true);
        held.current = null;
      }}
      onPointerCancel={() => (held.current = null)}
      onKeyDown={(event) => {
        const by = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 }[event.key];
        if (by === undefined) return;
        event.preventDefault();
        event.stopPropagation();
        step(event.shiftKey ? by * 10 : by);
      }}
    />
  );
}
