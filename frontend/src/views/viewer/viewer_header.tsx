import { useMemo } from "preact/hooks";
import type { DataSet } from "../../api/types";
import type { KeyCommand } from "../../input/keys";
import type { Role } from "../../live/role";
import { t } from "../../texts";
import { isVisitOver } from "../../protocol/connection";
import type { ViewerSession } from "../../video/viewer_session";
import { IconButton } from "../icon_button";
import { Icon, type IconName } from "../icons";
import { Link } from "../router";
import { ThemeSwitch } from "../shell";
import { SlicesButton } from "./slices/slice_views";
import { Invitation, wayBack, type Visitor } from "./visitor";
import type { OpenDialog } from "./viewer_dialogs";

export interface ViewerHeaderProps {
  readonly title: string;
  readonly session: ViewerSession | null;
  readonly role: Role;
  /** Whether the scan belongs to the user or is shared with them, so that they have an account. */
  readonly own: boolean;
  readonly set: DataSet | null;
  readonly visitor: Visitor | undefined;
  readonly cutting: boolean;
  /** Whether a second scan is shown over this one. */
  readonly fused: boolean;
  readonly obey: (command: KeyCommand) => void;
  readonly open: (dialog: OpenDialog) => void;
}

/** The title of the scan and the toolbar. */
export function ViewerHeader(props: ViewerHeaderProps) {
  const back = useMemo(() => wayBack(props.visitor), [props.visitor]);
  return (
    <header class="viewer-top">
      <div class="glass viewer-title">
        <Link href={back.href} class="icon-button" label={back.text}>
          <Icon name="back" />
        </Link>
        <h1>{props.title}</h1>
        {props.visitor ? <Invitation /> : null}
      </div>
      <ViewerTools {...props} />
    </header>
  );
}

function ViewerTools({ session, role, own, set, cutting, fused, obey, open }: ViewerHeaderProps) {
  const isOver = session !== null && isVisitOver(session.connection.value);
  return (
    <div class="glass viewer-tools">
      {session && !cutting ? <SlicesButton session={session} /> : null}
      {isOver ? null : (
        <>
          <CommandButton command="reset" icon="reset" obey={obey} />
          <CommandButton command="screenshot" icon="camera" obey={obey} />
        </>
      )}
      <CommandButton command="fullscreen" icon="fullscreen" obey={obey} />
      <ThemeSwitch />
      {own ? (
        <IconButton class="tool-recording" icon="record" label={t.recording.open} onClick={() => open("recording")} />
      ) : null}
      {set ? (
        <IconButton class="tool-presets" icon="star" label={t.presets.open} onClick={() => open("presets")} />
      ) : null}
      {set && !cutting && !fused ? (
        <IconButton class="tool-compare" icon="compare" label={t.compare.open} onClick={() => open("compare")} />
      ) : null}
      {set?.owned ? (
        <IconButton class="tool-scan" icon="globe" label={t.sharing.open} onClick={() => open("scan")} />
      ) : null}
      {isOver ? null : <ShareButton others={role.others} onClick={() => open("share")} />}
      <CommandButton command="help" icon="help" obey={obey} />
    </div>
  );
}

interface CommandButtonProps {
  readonly command: "reset" | "fullscreen" | "screenshot" | "help";
  readonly icon: IconName;
  readonly obey: (command: KeyCommand) => void;
}

function CommandButton({ command, icon, obey }: CommandButtonProps) {
  return (
    <IconButton
      class={`tool-${command}`}
      icon={icon}
      label={t.viewer[command]}
      onClick={() => obey({ kind: command })}
    />
  );
}

/** Opens the dialog for the live session, and shows how many people are in it. */
function ShareButton({ others, onClick }: { readonly others: number; readonly onClick: () => void }) {
  return (
    <button
      type="button"
      class="icon-button tool-share"
      aria-label={others > 0 ? t.live.openHere(others + 1) : t.live.open}
      title={t.live.open}
      onClick={onClick}
    >
      <Icon name="people" />
      {others > 0 ? <span class="count">{others + 1}</span> : null}
    </button>
  );
}
