import { t } from "../../texts";
import { Icon } from "../icons";
import { navigate } from "../router";
import { Notice } from "../shell";
import { useAct } from "../use_act";
import type { StudyEditing } from "./use_study";

/** What is missing, and the buttons to save and to try the study. */
export function SavePart({ editing }: { readonly editing: StudyEditing }) {
  const { act, busy, outcome } = useAct();
  const { study, findings, dirty } = editing;
  const text = t.studies;
  const save = () =>
    act(async () => {
      await editing.save();
      return text.saved;
    });
  const preview = () =>
    act(async () => {
      navigate(`/studies/${(await editing.save()).id}#preview`);
      return "";
    });
  const incomplete = findings.length > 0;
  return (
    <section class="study-save">
      {incomplete ? <Missing editing={editing} /> : null}
      <div class="study-choices">
        <button type="button" class="button button-main" disabled={busy || !dirty || incomplete} onClick={save}>
          {text.save}
        </button>
        {dirty ? (
          <button type="button" class="button" disabled={busy} onClick={editing.discard}>
            {text.discard}
          </button>
        ) : null}
        <button type="button" class="button" disabled={busy || incomplete} title={text.previewHint} onClick={preview}>
          {text.preview}
        </button>
      </div>
      {outcome}
      {dirty && study ? <p class="muted">{text.unsaved}</p> : null}
      {dirty && editing.stale ? <Notice kind="warn">{text.changedElsewhere}</Notice> : null}
      {dirty && study?.state === "open" ? <Notice kind="warn">{text.savesToDraft}</Notice> : null}
    </section>
  );
}

/** What keeps the study from being saved: first in the study as a whole, then in its steps. */
function Missing({ editing: { definition, findings } }: { readonly editing: StudyEditing }) {
  const text = t.studies;
  const steps = definition?.steps ?? [];
  return (
    <div class="notice notice-warn" role="status">
      <Icon name="alert" />
      <div>
        <p>{text.missing}</p>
        <ul class="study-missing">
          {findings.map(({ problem, step }) => {
            const at = steps.findIndex(({ id }) => id === step);
            const kind = steps[at]?.kind;
            const where = kind ? `${text.step(at + 1, text.kinds[kind])}: ` : "";
            return <li key={`${step ?? ""}/${problem}`}>{`${where}${text.problems[problem]}`}</li>;
          })}
        </ul>
      </div>
    </div>
  );
}
