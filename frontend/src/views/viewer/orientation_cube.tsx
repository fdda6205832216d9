import { cubeFaces, type CubeFace } from "../../input/cube";
import { cameraOf } from "../../protocol/messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";

interface CubeProps {
  readonly session: ViewerSession;
  /** Whether the faces can be pressed. */
  readonly leads: boolean;
}

/**
 * Shows the viewed side of the patient: L, R, A, P, S or I on a cube that rotates with the picture. A press on a face
 * turns the picture to that side at the same zoom.
 */
export function OrientationCube({ session, leads }: CubeProps) {
  const scene = session.editor.scene.value;
  const pose = scene ? cameraOf(scene) : null;
  if (!pose) return null;
  const faces = cubeFaces(pose);
  const nearest = faces.at(-1);
  return (
    <svg
      class="cube"
      viewBox="-1.9 -1.9 3.8 3.8"
      role={leads ? "group" : "img"}
      aria-label={nearest ? t.viewer.orientation(t.viewer.sides[nearest.letter] ?? "") : ""}
    >
      {faces.map((face) => (
        <Face key={face.letter} face={face} press={leads ? () => session.guide.turnTo(face.letter) : null} />
      ))}
    </svg>
  );
}

function Face({ face, press }: { readonly face: CubeFace; readonly press: (() => void) | null }) {
  const side = t.viewer.viewFrom(t.viewer.sides[face.letter] ?? "");
  return (
    <g
      opacity={0.45 + 0.55 * face.facing}
      data-side={face.letter}
      {...(press
        ? {
            role: "button",
            tabIndex: 0,
            "aria-label": side,
            onClick: press,
            onKeyDown: (event: KeyboardEvent) => {
              if (event.key !== "Enter" && event.key !== " ") return;
              event.preventDefault();
              event.stopPropagation();
              press();
            },
          }
        : {})}
    >
      {press ? <title>{side}</title> : null}
      <polygon class="cube-face" points={face.corners.map(({ x, y }) => `${x.toFixed(3)},${y.toFixed(3)}`).join(" ")} />
      {face.facing > 0.25 ? (
        <text
          class="cube-letter"
          x={face.middle.x}
          y={face.middle.y}
          dy="0.27"
          opacity={Math.min(1, face.facing * 1.6)}
        >
          {face.letter}
        </text>
      ) : null}
    </g>
  );
}
