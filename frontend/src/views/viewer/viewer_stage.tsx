import type { RefObject } from "preact";
import type { Role } from "../../live/role";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Divider } from "../compare/divider";
import type { InPicture } from "../picture/in_picture";
import { PictureHandles } from "../picture/picture_handles";
import { PicturePointers } from "../picture/pointers";
import { PointPicker } from "../picture/point_picker";
import { numberOf, PictureMarks } from "../marks/picture_marks";
import { looksOnKeys } from "./looks_on_keys";
import { LostEnvironment } from "./lost_environment";
import { SliceViews } from "./slices/slice_views";

export interface ViewerStageProps {
  readonly canvas: RefObject<HTMLCanvasElement | null>;
  readonly session: ViewerSession | null;
  readonly role: Role;
  readonly picture: InPicture;
  /** Whether the scan is being cut. The cut has its own handles. */
  readonly cutting: boolean;
}

/** The picture, with the slices next to it and the handles on top. */
export function ViewerStage({ canvas, session, role, picture, cutting }: ViewerStageProps) {
  return (
    <main class="stage">
      <canvas
        ref={canvas}
        tabIndex={0}
        role="application"
        aria-label={t.viewer.stage(looksOnKeys(session, role))}
        {...pictureData(session)}
        onDblClick={() => session?.slices.open.value && session.slices.maximise("picture")}
      />
      {session ? <SliceViews session={session} number={numberOf(role)} /> : null}
      {session ? <PicturePointers session={session} role={role} /> : null}
      {session && !cutting ? <PictureMarks session={session} role={role} /> : null}
      {session ? <LostEnvironment session={session} /> : null}
      {session && role.presents ? <Divider session={session} /> : null}
      {session && role.presents && !cutting ? <PictureHandles session={session} picture={picture} /> : null}
      {session && role.presents ? <PointPicker picture={picture} /> : null}
    </main>
  );
}

/** Returns data attributes that describe the shown picture, for tests and user scripts. */
export function pictureData(session: ViewerSession | null): Record<string, string> {
  const facts = session?.pictures.picture.value;
  if (!facts) return {};
  const lossless = session.pictures.lossless.value;
  return {
    ...(lossless ? { "data-lossless": String(lossless.samples) } : {}),
    "data-epoch": String(facts.epoch),
    "data-input-seq": String(facts.inputSeq),
    "data-samples": String(facts.samples),
    "data-error": String(facts.error),
    "data-phase": String(facts.phase),
  };
}
