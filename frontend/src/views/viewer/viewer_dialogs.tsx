import type { DataSet } from "../../api/types";
import type { Role } from "../../live/role";
import { isVisitOver } from "../../protocol/connection";
import type { ViewerSession } from "../../video/viewer_session";
import { ChooseScanDialog } from "../compare/choose_scan";
import { ShareScanDialog } from "../share_scan";
import { ExportDialog, type ExportDialogProps } from "./export/export_dialog";
import type { Shot } from "./export/shot";
import { HelpDialog, type HelpDialogProps } from "./help_dialog";
import { looksOnKeys } from "./looks_on_keys";
import { RecordingDialog } from "./recording";
import { SavedPresets } from "./saved_presets";
import { ShareDialog } from "./share_dialog";

export type OpenDialog = "help" | "share" | "recording" | "scan" | "presets" | "export" | "film" | "compare";

export interface ViewerDialogsProps {
  readonly open: OpenDialog | null;
  readonly close: () => void;
  readonly session: ViewerSession | null;
  readonly role: Role;
  readonly own: boolean;
  readonly set: DataSet | null;
  readonly onChange: (set: DataSet) => void;
  readonly shot: Shot;
}

/** The open dialog, if any. Most dialogs need a session or the facts about the scan. */
export function ViewerDialogs({ open, close, session, role, own, set, onChange, shot }: ViewerDialogsProps) {
  switch (open) {
    case "help":
      return <HelpDialog has={buttonsOf(session, own, set)} looks={looksOnKeys(session, role)} onClose={close} />;
    case "share":
      return session ? <ShareDialog session={session} role={role} owner={own} onClose={close} /> : null;
    case "scan":
      return set ? <ShareScanDialog set={set} onChange={onChange} onClose={close} /> : null;
    case "presets":
      return set && session ? <SavedPresets session={session} set={set} onClose={close} /> : null;
    case "export":
    case "film":
      return session && !isVisitOver(session.connection.value) ? (
        <ExportOfPicture
          session={session}
          role={role}
          set={set}
          shot={shot}
          what={open === "film" ? "around" : "picture"}
          close={close}
        />
      ) : null;
    case "compare":
      return set ? <ChooseScanDialog first={set} onClose={close} /> : null;
    case "recording":
      return <RecordingDialog onClose={close} />;
    case null:
      return null;
  }
}

function buttonsOf(session: ViewerSession | null, own: boolean, set: DataSet | null): HelpDialogProps["has"] {
  const slices = session?.slices.available.value ?? false;
  const phases = (session?.phases.phases.value.length ?? 0) > 1;
  return { slices, account: own, presets: set !== null, sharing: set?.owned ?? false, phases };
}

export const maySaveVideos = (session: ViewerSession, role: Role): boolean =>
  session.audience.value?.downloads ?? !role.guest;

type ExportOfPictureProps = Pick<ViewerDialogsProps, "role" | "set" | "shot" | "close"> & {
  readonly session: ViewerSession;
  readonly what: ExportDialogProps["what"];
};

function ExportOfPicture({ session, role, set, shot, what, close }: ExportOfPictureProps) {
  return (
    <ExportDialog
      session={session}
      what={what}
      rendered={maySaveVideos(session, role)}
      exportable={!role.guest && (set?.owned ?? false)}
      guest={role.guest}
      busy={shot.state?.kind === "rendering"}
      onExport={(order) => {
        close();
        shot.take(order);
      }}
      onClose={close}
    />
  );
}
