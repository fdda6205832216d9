import { useState } from "preact/hooks";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Choice } from "../../choice";
import { Dialog } from "../../dialog";
import { VideoForm } from "./video_form";
import { LinkPart } from "./link_part";
import { PictureForm } from "./picture_form";
import { decorated, decorationOf, marksInPicture } from "../../marks/in_pictures";
import { Switch } from "../settings/controls";
import { saveFile } from "./save_file";
import type { ExportOrder } from "./shot";

export interface ExportDialogProps {
  readonly session: ViewerSession;
  /** Whether pictures of any size can be rendered, which requires access to the scan. */
  readonly rendered: boolean;
  /** Whether a file is being rendered already. */
  readonly busy: boolean;
  readonly onExport: (order: ExportOrder) => void;
  readonly onClose: () => void;
}

export function ExportDialog({ session, rendered, busy, onExport, onClose }: ExportDialogProps) {
  const text = t.take;
  const [what, setWhat] = useState<keyof typeof text.kinds>("picture");
  return (
    <Dialog title={text.title} onClose={onClose}>
      <section class="share-part" aria-labelledby="take-picture">
        <h3 id="take-picture">{rendered ? text.file : text.picture}</h3>
        {rendered ? (
          <Choice
            label={text.what}
            value={what}
            options={Object.entries(text.kinds)}
            onChoose={(kind) => setWhat(kind as typeof what)}
          />
        ) : null}
        {!rendered || what === "picture" ? <PictureNow session={session} main={!rendered} /> : null}
        {!rendered ? null : what === "picture" ? (
          <PictureForm session={session} busy={busy} onExport={onExport} />
        ) : (
          <VideoForm key={what} session={session} kind={what} busy={busy} onExport={onExport} />
        )}
      </section>
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

/** The picture on the screen. In another person's session, this is the only possible export. */
function PictureNow({ session, main }: Pick<ExportDialogProps, "session"> & { readonly main: boolean }) {
  const [withMarks, setWithMarks] = useState(true); // as on the screen
  const count = marksInPicture(session).length;
  const save = async () => {
    const png = await session.pictures.png();
    if (png) saveFile(withMarks && count > 0 ? await decorated(png, decorationOf(session, true)) : png);
  };
  return (
    <>
      <p class="muted">{t.take.pictureNow}</p>
      {count > 0 ? <Switch label={t.marks.includeInPicture(count)} on={withMarks} change={setWithMarks} /> : null}
      <p>
        <button type="button" class={`button${main ? " button-main" : ""}`} onClick={() => void save()}>
          {main ? t.take.save : t.take.saveNow}
        </button>
      </p>
    </>
  );
}
