import { noFlick } from "../../../input/no_flick";
import { unitOf, type Direction } from "../../../scene/direction";
import { t } from "../../../texts";
import { ballMargin, ballRadius, useBallGestures, type BallActs } from "./use_ball_gestures";

export interface LightBallProps extends BallActs {
  readonly direction: Direction;
  readonly others: readonly Direction[];
  readonly leads: boolean;
}

const half = ballRadius + ballMargin;

/** The direction of a light as a point on a ball. A point beyond the rim is on the back. */
export function LightBall({ direction, others, leads, change, rest }: LightBallProps) {
  const gestures = useBallGestures(direction, leads, { change, rest });
  return (
    <svg
      ref={gestures.svg}
      class="ball"
      viewBox={`${-half} ${-half} ${2 * half} ${2 * half}`}
      role="application"
      tabindex={0}
      aria-label={t.settings.light.ball(direction.right.toFixed(0), direction.up.toFixed(0))}
      onTouchMove={noFlick}
      onPointerDown={gestures.grab}
      onPointerMove={gestures.drag}
      onPointerUp={gestures.drop}
      onPointerCancel={gestures.drop}
      onKeyDown={gestures.key}
    >
      <BallDrawing direction={direction} others={others} />
    </svg>
  );
}

function BallDrawing({ direction, others }: Pick<LightBallProps, "direction" | "others">) {
  const at = unitOf(direction);
  const [x, y] = [at.x * ballRadius, -at.y * ballRadius];
  return (
    <>
      <circle class="ball-body" r={ballRadius} />
      <ellipse class="ball-line" rx={ballRadius} ry={ballRadius * 0.3} />
      <ellipse class="ball-line" rx={ballRadius * 0.3} ry={ballRadius} />
      {others.map(unitOf).map((o, i) => (
        <circle key={i} class="ball-other" cx={o.x * ballRadius} cy={-o.y * ballRadius} r={3} />
      ))}
      <line class="ball-ray" x1={x} y1={y} x2={0} y2={0} />
      <circle class={at.z < 0 ? "ball-dot ball-dot-behind" : "ball-dot"} cx={x} cy={y} r={7} />
    </>
  );
}
