import type { Region } from "../../cut/region";
import type { Role } from "../../live/role";
import { isOver } from "../../protocol/connection";
import type { ViewerSession } from "../../video/viewer_session";
import { CutPanel } from "../cut/cut_panel";
import type { InPicture } from "../picture/in_picture";
import { Hints } from "./hints";
import { PhaseLine } from "./phase_line";
import { OrientationCube } from "./orientation_cube";
import { Presets } from "./presets";
import { QualityPanel } from "./quality_panel";
import { Settings } from "./settings/settings";

export interface ViewerPanelsProps {
  readonly session: ViewerSession;
  readonly role: Role;
  readonly picture: InPicture;
  /** The scan to cut, and the callback for a confirmed cut. */
  readonly cut: CutTask | null;
  readonly focusPicture: () => void;
}

export interface CutTask {
  readonly dataSetId: string;
  readonly onConfirm: (region: Region, volumeHash: string) => void;
}

/** The panels over the picture. There are none once the rendering time is used up, or a visit is over. */
export function ViewerPanels({ session, role, picture, cut, focusPicture }: ViewerPanelsProps) {
  if (isOver(session.connection.value)) return null;
  return (
    <>
      <OrientationCube session={session} leads={role.presents} />
      {cut ? <CutPanel session={session} dataSetId={cut.dataSetId} onConfirm={cut.onConfirm} /> : null}
      {cut ? null : (
        <>
          {role.presents ? <Presets session={session} /> : null}
          <PhaseLine session={session} role={role} />
          <Settings session={session} leads={role.presents} cuts={!role.guest} picture={picture} />
          <QualityPanel session={session} />
          {role.presents && session.pictures.picture.value ? <Hints onDone={focusPicture} /> : null}
        </>
      )}
    </>
  );
}
