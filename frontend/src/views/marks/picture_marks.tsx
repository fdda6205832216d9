import { useRef } from "preact/hooks";
import type { Point } from "../../input/flat";
import type { Role } from "../../live/role";
import { viewOfPicture } from "../../marks/view";
import { eyeOf } from "../../picture/handles";
import { pictureIn, type Rectangle } from "../../video/picture_in";
import type { ViewerSession } from "../../video/viewer_session";
import { useScreen } from "../picture/use_screen";
import { MarkHandles } from "./mark_handles";
import { MarkMaker } from "./mark_maker";
import { MarkShapes } from "./mark_shapes";

export interface PictureMarksProps {
  readonly session: ViewerSession;
  readonly role: Role;
}

/** Returns the number of this viewer in the session, or 0 if it is unknown. */
export const numberOf = ({ people, you }: Role): number => people.find(({ id }) => id === you)?.number ?? 0;

/** The marks over the picture, where they are also created and changed. */
export function PictureMarks({ session, role }: PictureMarksProps) {
  const { marks } = session;
  const needed = marks.editing.value || marks.items.value.length + marks.others.value.size > 0;
  return needed ? <Layer session={session} role={role} /> : null;
}

function Layer({ session, role }: PictureMarksProps) {
  const { marks } = session;
  const layer = useRef<HTMLDivElement>(null);
  const screen = useScreen(layer);
  const scene = session.editor.scene.value;
  const eye = scene && eyeOf(scene);
  const picture = session.pictures.picture.value;
  const drawn = picture && pictureIn(screen, picture, role.follows && !role.freeCamera);
  const view = eye && drawn ? viewOfPicture(eye, drawn, marks.hidden.value) : null;
  const number = numberOf(role);
  const locate = (at: Point) => (drawn ? surfaceAt(session, drawn, at) : Promise.resolve(null));
  return (
    <div class="handle-area mark-area" ref={layer}>
      {view ? (
        <>
          <svg width={screen.width} height={screen.height} aria-hidden="true">
            <MarkShapes marks={marks} number={number} view={view} area={screen} />
          </svg>
          <MarkHandles marks={marks} number={number} view={view} locate={locate} />
          <MarkMaker marks={marks} view={view} area={screen} locate={locate} focused />
        </>
      ) : null}
    </div>
  );
}

/** Returns the place of the surface that is visible at a point of the page. */
async function surfaceAt(session: ViewerSession, { x, y, width, height }: Rectangle, at: Point) {
  const across = (at.x - x) / width,
    down = (at.y - y) / height;
  if (across < 0 || across > 1 || down < 0 || down > 1) return null;
  const answer = await session.depthAt(across, down);
  return answer.answered ? (answer.seen?.place ?? null) : null;
}
