import { useId, useState } from "preact/hooks";
import { t } from "../texts";
import { Dialog } from "./dialog";
import { Notice } from "./shell";
import { useApp } from "./state";

export interface ReportDialogProps {
  readonly title: string;
  /** By their words for the server. */
  readonly reasons: Readonly<Record<string, string>>;
  readonly send: (reason: string, words: string) => Promise<void>;
  readonly onClose: () => void;
}

/** To the administrators: what is wrong with somebody's public scan, or with a preset for it. */
export function ReportDialog({ title, reasons, send, onClose }: ReportDialogProps) {
  const app = useApp();
  const id = useId();
  const [reason, set_reason] = useState(Object.keys(reasons)[0] ?? "other");
  const [words, set_words] = useState("");
  const [fault, set_fault] = useState("");
  const [sent, set_sent] = useState(false);
  const text = t.sharing.report;
  const report = () => {
    send(reason, words).then(() => set_sent(true), (thrown: unknown) => set_fault(app.explain(thrown)));
  };
  return (
    <Dialog title={title} onClose={onClose}>
      {sent ? <Notice kind="good">{text.sent}</Notice> : (
        <>
          <p class="muted">{text.lead}</p>
          <fieldset class="reasons">
            <legend class="visually-hidden">{title}</legend>
            {Object.entries(reasons).map(([one, name]) => (
              <label key={one}>
                <input type="radio" name={`${id}-reason`} value={one} checked={one === reason} onChange={() => set_reason(one)} />
                {name}
              </label>
            ))}
          </fieldset>
          <div class="field">
            <label for={`${id}-words`}>{text.words}</label>
            <textarea id={`${id}-words`} class="prose" rows={3} maxLength={1000} value={words} onInput={(event) => set_words(event.currentTarget.value)} />
          </div>
          {fault ? <Notice kind="bad">{fault}</Notice> : null}
        </>
      )}
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>{sent ? t.close : t.cancel}</button>
        {sent ? null : <button type="button" class="button button-danger" onClick={report}>{text.send}</button>}
      </div>
    </Dialog>
  );
}
