import { useState } from "preact/hooks";
import { roleOf } from "../../../live/role";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Choice } from "../../choice";
import { Dialog } from "../../dialog";
import { VideoForm } from "./video_form";
import { LinkPart } from "./link_part";
import { PictureForm } from "./picture_form";
import { ScanFile } from "./scan_file";
import type { ExportOrder } from "./shot";

export interface ExportDialogProps {
  readonly session: ViewerSession;
  /** What is chosen at first. */
  readonly what: keyof typeof t.take.kinds;
  /** Whether the owner of the scan allows videos, and pictures of any size. */
  readonly rendered: boolean;
  /** Whether the viewer is a guest of someone's session, who gets only the picture on the screen. */
  readonly guest: boolean;
  /** Whether the viewer owns the scan and may export it. */
  readonly exportable: boolean;
  /** Whether a file is being rendered already. */
  readonly busy: boolean;
  readonly onExport: (order: ExportOrder) => void;
  readonly onClose: () => void;
}

export function ExportDialog(props: ExportDialogProps) {
  const { session, what: first, rendered, guest, exportable, busy, onExport, onClose } = props;
  const text = t.take;
  const [what, setWhat] = useState(first);
  // A tour goes through saved presets, which a visitor without an account does not have. Only the presenter gets views.
  const isOffered = (kind: string) => {
    if (kind === "tour") return session.dataSetId !== null;
    if (kind === "phases") return session.phases.phases.value.length > 1;
    return kind !== "around" || roleOf(session.audience.value).presents;
  };
  return (
    <Dialog title={text.title} onClose={onClose}>
      <section class="share-part" aria-labelledby="take-picture">
        <h3 id="take-picture">{rendered ? text.file : text.picture}</h3>
        {rendered ? (
          <Choice
            label={text.what}
            value={what}
            options={Object.entries(text.kinds).filter(([kind]) => isOffered(kind))}
            onChoose={(kind) => setWhat(kind as typeof what)}
          />
        ) : null}
        {rendered || guest ? null : <p class="muted">{text.onlyScreen}</p>}
        {!rendered || what === "picture" ? (
          <PictureForm session={session} rendered={rendered} busy={busy} onExport={onExport} />
        ) : (
          <VideoForm key={what} session={session} kind={what} busy={busy} onExport={onExport} />
        )}
      </section>
      {exportable && session.dataSetId !== null ? (
        <section class="share-part" aria-labelledby="take-scan">
          <h3 id="take-scan">{t.scanFile.title}</h3>
          <ScanFile session={session} dataSetId={session.dataSetId} />
        </section>
      ) : null}
      {session.dataSetId !== null ? (
        <section class="share-part" aria-labelledby="take-link">
          <h3 id="take-link">{text.link}</h3>
          <LinkPart session={session} dataSetId={session.dataSetId} />
        </section>
      ) : null}
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>
          {t.close}
        </button>
      </div>
    </Dialog>
  );
}
