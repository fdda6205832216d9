import { useState } from "preact/hooks";
import type { StudyInvitation } from "../../api/studies";
import { textIn } from "../../studies/definition";
import { language, t } from "../../texts";
import { Notice, PageTitle } from "../shell";
import { Paragraphs, StudyMessage } from "./study_frame";

export interface InvitationFormProps {
  readonly invitation: StudyInvitation;
  readonly fault: string;
  readonly join: (record: boolean) => Promise<void>;
}

/** Who asks, what happens, and the consent. */
export function InvitationForm({ invitation, fault, join }: InvitationFormProps) {
  const [record, setRecord] = useState<boolean | null>(invitation.record ? null : false);
  const [busy, setBusy] = useState(false);
  const [asked, setAsked] = useState(false);
  const text = t.takePart;
  const title = textIn(invitation.title, language.value);
  const refused = !invitation.open ? text.closed : invitation.places_left <= 0 ? text.full : "";
  return (
    <StudyMessage>
      <div lang={title.lang}>
        <PageTitle text={title.text} />
      </div>
      <p class="lead">
        {[invitation.researcher ? text.by(invitation.researcher) : "", text.steps(invitation.steps - 1)]
          .filter(Boolean)
          .join(" · ")}
      </p>
      {refused ? (
        <Notice kind="info">{refused}</Notice>
      ) : (
        <form
          class="study-consent"
          onSubmit={(event) => {
            event.preventDefault();
            setAsked(true);
            if (record === null) return;
            setBusy(true);
            void join(record).finally(() => setBusy(false));
          }}
        >
          <h2>{text.about}</h2>
          <Paragraphs {...textIn(invitation.consent, language.value)} />
          <p class="muted">{text.privacy}</p>
          {invitation.record ? <RecordChoice record={record} choose={setRecord} /> : null}
          <p class="field-fault" role="alert">
            {asked && record === null ? text.chooseRecord : ""}
          </p>
          {fault ? <Notice kind="bad">{fault}</Notice> : null}
          <button type="submit" class="button button-main button-wide" disabled={busy}>
            {text.agree}
          </button>
        </form>
      )}
    </StudyMessage>
  );
}

interface RecordChoiceProps {
  readonly record: boolean | null;
  readonly choose: (record: boolean) => void;
}

/** The choice whether the interaction is recorded. Nothing is chosen beforehand. */
function RecordChoice({ record, choose }: RecordChoiceProps) {
  const text = t.takePart;
  const option = (value: boolean, label: string) => (
    <label>
      <input type="radio" name="record" checked={record === value} onChange={() => choose(value)} />
      {label}
    </label>
  );
  return (
    <fieldset class="reasons">
      <legend>{text.recordTitle}</legend>
      <p>{text.recordText}</p>
      {option(true, text.recordYes)}
      {option(false, text.recordNo)}
    </fieldset>
  );
}
