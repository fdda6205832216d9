import { useId, useState } from "preact/hooks";
import type { DataSet } from "../api/types";
import { t } from "../texts/en";
import { Dialog } from "./dialog";
import { Notice } from "./shell";
import { useApp } from "./state";

/** To the administrators: what is wrong with somebody's public scan. */
export function ReportDialog({ set, onClose }: { readonly set: DataSet; readonly onClose: () => void }) {
  const app = useApp();
  const id = useId();
  const [reason, set_reason] = useState("identifies");
  const [words, set_words] = useState("");
  const [fault, set_fault] = useState("");
  const [sent, set_sent] = useState(false);
  const text = t.sharing.report;
  const send = () => {
    app.api.sharing.report(set.id, reason, words).then(() => set_sent(true), (thrown: unknown) => set_fault(app.explain(thrown)));
  };
  return (
    <Dialog title={text.title} onClose={onClose}>
      {sent ? <Notice kind="good">{text.sent}</Notice> : (
        <>
          <p class="muted">{text.lead}</p>
          <fieldset class="reasons">
            <legend class="visually-hidden">{text.title}</legend>
            {Object.entries(text.reasons).map(([one, name]) => (
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
        {sent ? null : <button type="button" class="button button-danger" onClick={send}>{text.send}</button>}
      </div>
    </Dialog>
  );
}
