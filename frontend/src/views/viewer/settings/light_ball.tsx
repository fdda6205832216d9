import { useRef } from "preact/hooks";
import { no_flick } from "../../../input/no_flick";
import { direction_on_ball, unit_of, type Direction } from "../../../scene/direction";
import { clamp } from "../../../scene/numbers";
import { t } from "../../../texts";

export interface LightBallProps {
  readonly direction: Direction;
  readonly others: readonly Direction[];
  readonly leads: boolean;
  readonly change: (direction: Direction, held: boolean) => void;
  readonly rest: () => void;
}

const radius = 50;
const ways: Readonly<Record<string, readonly [number, number]>> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const wrapped = (angle: number): number => angle - 360 * Math.round(angle / 360);

/** From where a light comes, on a ball: beyond the rim it goes on at the back. */
export function LightBall({ direction, others, leads, change, rest }: LightBallProps) {
  const svg = useRef<SVGSVGElement>(null);
  const held = useRef<boolean | null>(null);
  const at = unit_of(direction);

  const place = (event: PointerEvent) => {
    const box = svg.current?.getBoundingClientRect() ?? new DOMRect();
    const scale = (radius + 10) / Math.max(1, box.width / 2);
    return { x: ((event.clientX - box.x - box.width / 2) * scale) / radius, y: ((event.clientY - box.y - box.height / 2) * scale) / radius };
  };
  const point = (event: PointerEvent, behind: boolean) => {
    const { x, y } = place(event);
    const to = direction_on_ball(x, y, behind).direction;
    change({ right: Math.round(to.right), up: Math.round(to.up) }, true);
  };
  const grabbed = (event: PointerEvent) => {
    if (!leads || event.button !== 0) return;
    const { x, y } = place(event);
    const near = Math.hypot(x - at.x, y + at.y) < 0.25;
    held.current = near && at.z < 0; // what is taken hold of at the back stays there
    svg.current?.setPointerCapture(event.pointerId);
    if (!near) point(event, false);
  };
  const dropped = () => {
    if (held.current !== null) rest();
    held.current = null;
  };
  const pressed = (event: KeyboardEvent) => {
    if (!leads || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = event.shiftKey ? 15 : 5;
    const way = ways[event.key];
    if (!way) return;
    event.preventDefault();
    change({ right: wrapped(direction.right + step * way[0]), up: clamp(direction.up + step * way[1], -90, 90) }, false);
  };
  return (
    <svg ref={svg} class="ball" viewBox={`${-radius - 10} ${-radius - 10} ${2 * radius + 20} ${2 * radius + 20}`} role="application" tabindex={0}
      aria-label={t.settings.light.ball(direction.right.toFixed(0), direction.up.toFixed(0))}
      onTouchMove={no_flick} onPointerDown={grabbed} onPointerMove={(event) => {
        if (held.current !== null) point(event, held.current);
      }} onPointerUp={dropped} onPointerCancel={dropped} onKeyDown={pressed}>
      <circle class="ball-body" r={radius} />
      <ellipse class="ball-line" rx={radius} ry={radius * 0.3} />
      <ellipse class="ball-line" rx={radius * 0.3} ry={radius} />
      {others.map(unit_of).map((o, i) => <circle key={i} class="ball-other" cx={o.x * radius} cy={-o.y * radius} r={3} />)}
      <line class="ball-ray" x1={at.x * radius} y1={-at.y * radius} x2={0} y2={0} />
      <circle class={at.z < 0 ? "ball-dot ball-dot-behind" : "ball-dot"} cx={at.x * radius} cy={-at.y * radius} r={7} />
    </svg>
  );
}
