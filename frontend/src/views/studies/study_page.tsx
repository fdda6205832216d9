import { useRef, useState } from "preact/hooks";
import type { Study } from "../../api/studies";
import { textIn, type Definition } from "../../studies/definition";
import { language, t } from "../../texts";
import { Dialog } from "../dialog";
import { Loading } from "../loading";
import { Link, navigate } from "../router";
import { Notice, PageTitle } from "../shell";
import { useAct } from "../use_act";
import { AboutForm } from "./about_form";
import { ResultsPart } from "./results_part";
import { RunningPart } from "./running_part";
import { SavePart } from "./save_part";
import { StepList } from "./step_list";
import { StateChip } from "./studies";
import { useStudy, type StudyEditing } from "./use_study";
import { ViewEditor } from "./view_editor";
import type { ViewChoice } from "./view_settings";

/** A study of a researcher: its definition, its participants and its results. */
export function StudyPage({ studyId }: { readonly studyId: string }) {
  const editing = useStudy(studyId);
  const { choice, choose, close } = useViewChoice();
  return (
    <>
      {choice ? (
        <ViewEditor
          view={choice.view}
          kind={choice.kind}
          onCancel={close}
          onUse={(view) => {
            choice.use(view);
            close();
          }}
        />
      ) : null}
      <div class="page study-page" hidden={choice !== null}>
        <p>
          <Link href="/studies">{t.studies.back}</Link>
        </p>
        {choice ? null : <StudyHead editing={editing} />}
        {editing.definition ? <Composer editing={editing} definition={editing.definition} chooseView={choose} /> : null}
        {editing.study ? <RunningPart editing={editing} study={editing.study} /> : null}
        {editing.study ? <ResultsPart study={editing.study} /> : null}
        {editing.study ? <RemovePart study={editing.study} /> : null}
      </div>
    </>
  );
}

/** The choice of a picture, which hides the page for a while. Afterwards, the focus returns. */
function useViewChoice() {
  const [choice, setChoice] = useState<ViewChoice | null>(null);
  const from = useRef<Element | null>(null);
  const choose = (next: ViewChoice) => {
    from.current = document.activeElement;
    setChoice(next);
    scrollTo(0, 0);
  };
  const close = () => {
    setChoice(null);
    requestAnimationFrame(() => {
      if (from.current instanceof HTMLElement && from.current.isConnected) from.current.focus();
    });
  };
  return { choice, choose, close };
}

function StudyHead({ editing: { study, definition, fault } }: { readonly editing: StudyEditing }) {
  const title = definition ? textIn(definition.title, language.value).text || t.studies.untitled : t.studies.title;
  return (
    <>
      <div class="page-head">
        <PageTitle text={title} />
        {study ? <StateChip state={study.state} /> : null}
      </div>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      {definition === null && !fault ? <Loading /> : null}
    </>
  );
}

interface ComposerProps {
  readonly editing: StudyEditing;
  readonly definition: Definition;
  readonly chooseView: (choice: ViewChoice) => void;
}

function Composer({ editing, definition, chooseView }: ComposerProps) {
  const { study, findings, change } = editing;
  const frozen = study !== null && study.joined > 0;
  return (
    <>
      {frozen ? <Notice kind="info">{t.studies.frozen}</Notice> : null}
      <fieldset class="study-fields" disabled={frozen}>
        <AboutForm definition={definition} change={change} />
        <StepList
          definition={definition}
          findings={findings}
          study={study}
          save={editing.save}
          change={change}
          chooseView={chooseView}
        />
      </fieldset>
      {frozen ? null : <SavePart editing={editing} />}
    </>
  );
}

function RemovePart({ study }: { readonly study: Study }) {
  const { app, act, busy, outcome } = useAct();
  const [asking, setAsking] = useState(false);
  const text = t.studies;
  return (
    <section class="share-part">
      <p>
        <button type="button" class="button button-danger" onClick={() => setAsking(true)}>
          {text.removeStudy}
        </button>
      </p>
      {asking ? (
        <Dialog title={text.removeTitle} onClose={() => setAsking(false)}>
          <p>{text.removeText}</p>
          {outcome}
          <div class="dialog-buttons">
            <button type="button" class="button" onClick={() => setAsking(false)}>
              {t.cancel}
            </button>
            <button
              type="button"
              class="button button-danger"
              disabled={busy}
              onClick={() =>
                act(async () => {
                  await app.api.studies.remove(study.id);
                  navigate("/studies");
                  return "";
                })
              }
            >
              {text.removeStudy}
            </button>
          </div>
        </Dialog>
      ) : null}
    </section>
  );
}
