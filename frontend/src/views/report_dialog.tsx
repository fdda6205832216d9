import { useId, useState } from "preact/hooks";
import { t } from "../texts";
import { Dialog } from "./dialog";
import { Notice } from "./shell";
import { useApp } from "./state";

export interface ReportDialogProps {
  readonly title: string;
  /** The texts of the reasons, by their codes in the API. */
  readonly reasons: Readonly<Record<string, string>>;
  readonly send: (reason: string, words: string) => Promise<void>;
  readonly onClose: () => void;
}

/** Reports a public scan, or a preset for it, to the administrators. */
export function ReportDialog({ title, reasons, send, onClose }: ReportDialogProps) {
  const app = useApp();
  const id = useId();
  const [reason, setReason] = useState(Object.keys(reasons)[0] ?? "other");
  const [words, setWords] = useState("");
  const [fault, setFault] = useState("");
  const [sent, setSent] = useState(false);
  const text = t.sharing.report;
  const report = () => {
    send(reason, words).then(
      () => setSent(true),
      (thrown: unknown) => setFault(app.explain(thrown)),
    );
  };
  return (
    <Dialog title={sent ? text.sentTitle : title} onClose={onClose}>
      {sent ? (
        <Notice kind="good">{text.sent}</Notice>
      ) : (
        <>
          <p class="muted">{text.lead}</p>
          <ReasonChoice title={title} reasons={reasons} chosen={reason} choose={setReason} />
          <div class="field">
            <label for={`${id}-words`}>{text.words}</label>
            <textarea
              id={`${id}-words`}
              class="prose"
              rows={3}
              maxLength={1000}
              value={words}
              onInput={(event) => setWords(event.currentTarget.value)}
            />
          </div>
          {fault ? <Notice kind="bad">{fault}</Notice> : null}
        </>
      )}
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>
          {sent ? t.close : t.cancel}
        </button>
        {sent ? null : (
          <button type="button" class="button button-main" onClick={report}>
            {text.send}
          </button>
        )}
      </div>
    </Dialog>
  );
}

interface ReasonChoiceProps {
  readonly title: string;
  readonly reasons: Readonly<Record<string, string>>;
  readonly chosen: string;
  readonly choose: (reason: string) => void;
}

function ReasonChoice({ title, reasons, chosen, choose }: ReasonChoiceProps) {
  const id = useId();
  return (
    <fieldset class="reasons">
      <legend class="visually-hidden">{title}</legend>
      {Object.entries(reasons).map(([one, name]) => (
        <label key={one}>
          <input type="radio" name={`${id}-reason`} value={one} checked={one === chosen} onChange={() => choose(one)} />
          {name}
        </label>
      ))}
    </fieldset>
  );
}
