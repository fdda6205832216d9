import { cubeFaces } from "../../input/cube";
import { cameraOf } from "../../protocol/messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";

/** Shows the viewed side of the patient: L, R, A, P, S or I on a cube that rotates with the picture. */
export function OrientationCube({ session }: { readonly session: ViewerSession }) {
  const scene = session.editor.scene.value;
  const pose = scene ? cameraOf(scene) : null;
  if (!pose) return null;
  const faces = cubeFaces(pose);
  const nearest = faces.at(-1);
  return (
    <svg
      class="cube"
      viewBox="-1.9 -1.9 3.8 3.8"
      role="img"
      aria-label={nearest ? t.viewer.orientation(t.viewer.sides[nearest.letter] ?? "") : ""}
    >
      {faces.map((face) => (
        <g key={face.letter} opacity={0.45 + 0.55 * face.facing}>
          <polygon
            class="cube-face"
            points={face.corners.map(({ x, y }) => `${x.toFixed(3)},${y.toFixed(3)}`).join(" ")}
          />
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
      ))}
    </svg>
  );
}
