import { useRef } from "preact/hooks";
import type { Role } from "../../live/role";
import { eyeOf } from "../../picture/handles";
import { onScreen } from "../../picture/project";
import type { Pointer } from "../../protocol/shared_messages";
import { pictureIn } from "../../video/picture_in";
import type { ViewerSession } from "../../video/viewer_session";
import { nameOf } from "../viewer/share_dialog";
import { PointerMark } from "./pointer_mark";
import { useScreen } from "./use_screen";

export interface PicturePointersProps {
  readonly session: ViewerSession;
  readonly role: Role;
}

/** The pointers of the other participants, on the surfaces at which they point. */
export function PicturePointers({ session, role }: PicturePointersProps) {
  const pointers = [...session.collaboration.pointers.value.values()].filter(({ plane }) => plane === null);
  return pointers.length > 0 ? <Marks session={session} role={role} pointers={pointers} /> : null;
}

function Marks({ session, role, pointers }: PicturePointersProps & { readonly pointers: readonly Pointer[] }) {
  const layer = useRef<HTMLDivElement>(null);
  const screen = useScreen(layer);
  const scene = session.editor.scene.value;
  const eye = scene && eyeOf(scene);
  const picture = session.pictures.picture.value;
  const area = picture && pictureIn(screen, picture, role.follows && !role.freeCamera);
  return (
    <div class="handle-area" ref={layer} aria-hidden="true">
      {eye && area
        ? pointers.map(({ number, place }) => {
            const at = onScreen(eye, area, place);
            return at ? (
              <PointerMark
                key={number}
                at={{ x: area.x + at.x, y: area.y + at.y }}
                area={screen}
                number={number}
                name={nameOf(role.people, number)}
              />
            ) : null;
          })
        : null}
    </div>
  );
}
