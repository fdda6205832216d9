import { useState } from "preact/hooks";
import type { Study } from "../../api/studies";
import { studyLanguages, type Definition } from "../../studies/definition";
import { t } from "../../texts";
import { CopyField } from "../copy_field";
import { Dialog } from "../dialog";
import { QrCode } from "../qr_code";
import { Notice } from "../shell";
import { UserError } from "../state";
import { useAct } from "../use_act";
import type { StudyEditing } from "./use_study";

export interface RunningPartProps {
  readonly editing: StudyEditing;
  readonly study: Study;
}

/** Whether some texts still contain the notes of a template. */
const hasPlaceholders = ({ steps }: Definition): boolean =>
  steps.some(({ text }) => studyLanguages.some((language) => /\[[^\]]+\]/.test(text[language] ?? "")));

/** Whether people can take part, and their link. */
export function RunningPart({ editing, study }: RunningPartProps) {
  const { app, act, busy, outcome } = useAct();
  const [closing, setClosing] = useState(false);
  const text = t.studies;
  const setState = (state: "open" | "closed") =>
    act(async () => {
      // An open study can be closed even while its changes are incomplete.
      if (state === "open") await editing.save();
      await app.api.studies.setState(study.id, state);
      await editing.reload();
      setClosing(false);
      return "";
    });
  return (
    <section class="share-part">
      <h2>{text.running}</h2>
      <p>{{ draft: text.draftText, open: text.openText, closed: text.closedText }[study.state]}</p>
      <p>{text.joined(study.joined, study.places, study.finished)}</p>
      {study.withdrawn > 0 ? <p>{text.withdrawn(study.withdrawn)}</p> : null}
      {study.state !== "closed" && hasPlaceholders(study.definition) ? (
        <Notice kind="warn">{text.placeholders}</Notice>
      ) : null}
      <div class="study-choices">
        {study.state === "open" ? (
          <button type="button" class="button" disabled={busy} onClick={() => setClosing(true)}>
            {text.closeStudy}
          </button>
        ) : (
          <button
            type="button"
            class="button button-main"
            disabled={busy || editing.findings.length > 0}
            onClick={() => setState("open")}
          >
            {study.state === "draft" ? text.openStudy : text.openAgain}
          </button>
        )}
      </div>
      {outcome}
      <LinkPart study={study} />
      {closing ? (
        <Dialog title={text.closeTitle} onClose={() => setClosing(false)}>
          <p>{text.closeConfirm}</p>
          <div class="dialog-buttons">
            <button type="button" class="button" onClick={() => setClosing(false)}>
              {t.cancel}
            </button>
            <button type="button" class="button button-danger" disabled={busy} onClick={() => setState("closed")}>
              {text.closeStudy}
            </button>
          </div>
        </Dialog>
      ) : null}
    </section>
  );
}

/** The link for participants, which can be shown only once. */
function LinkPart({ study }: { readonly study: Study }) {
  const { app, act, busy, outcome } = useAct();
  const [link, setLink] = useState("");
  const text = t.studies;
  const make = () =>
    act(async () => {
      setLink(location.origin + (await app.api.studies.makeLink(study.id)).path);
      return "";
    });
  const copy = () =>
    act(async () => {
      await navigator.clipboard.writeText(link).catch(() => {
        throw new UserError(text.linkCopyFailed);
      });
      return text.linkCopied;
    });
  return (
    <div class="study-link">
      <p class="field-hint">{text.linkHint}</p>
      {link ? (
        <>
          <CopyField value={link} label={text.link} button={text.linkCopy} onCopy={copy} />
          <QrCode text={link} label={text.qr} />
        </>
      ) : null}
      <p>
        <button type="button" class="button" disabled={busy} onClick={make}>
          {link ? text.makeLinkAgain : text.makeLink}
        </button>
      </p>
      {outcome}
    </div>
  );
}
