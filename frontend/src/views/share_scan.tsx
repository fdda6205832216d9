import { useId, useState } from "preact/hooks";
import { bodyParts, type DataSet } from "../api/types";
import { t } from "../texts";
import { Choice } from "./choice";
import { CloseButton, Dialog } from "./dialog";
import { Field } from "./field";
import { SharePublicly } from "./share_publicly";
import { ShareByLink } from "./share_by_link";
import { ShareWithPeople } from "./share_with_people";
import { Notice } from "./shell";
import { useAct } from "./use_act";
import { ViewLogDialog } from "./view_log";

export interface ShareScanProps {
  readonly set: DataSet;
  readonly onChange: (set: DataSet) => void;
  readonly onClose: () => void;
}

interface PartProps {
  readonly set: DataSet;
  readonly onChange: (set: DataSet) => void;
}

/** The owner's description of a scan, and who else may see it. */
export function ShareScanDialog({ set, onChange, onClose }: ShareScanProps) {
  return (
    <Dialog title={t.sharing.title} onClose={onClose}>
      <p class="muted">{t.sharing.lead}</p>
      {set.taken_down ? <Notice kind="bad">{t.sharing.everybody.takenDown(set.taken_down.reason)}</Notice> : null}
      {set.taken_down ? null : (
        <>
          <ShareWithPeople set={set} />
          <ShareByLink set={set} />
          <SharePublicly set={set} onChange={onChange} />
        </>
      )}
      <Details set={set} onChange={onChange} />
      <Views dataSetId={set.id} />
      <CloseButton onClick={onClose} />
    </Dialog>
  );
}

/** Opens the log of who viewed the scan. */
function Views({ dataSetId }: { readonly dataSetId: string }) {
  const [open, setOpen] = useState(false);
  return (
    <p>
      <button type="button" class="button" onClick={() => setOpen(true)}>
        {t.sharing.views.open}
      </button>
      {open ? <ViewLogDialog dataSetId={dataSetId} onClose={() => setOpen(false)} /> : null}
    </p>
  );
}

function Details({ set, onChange }: PartProps) {
  const { app, act, busy, outcome } = useAct();
  const id = useId();
  const [title, setTitle] = useState(set.title);
  const [description, setDescription] = useState(set.description);
  const [bodyPart, setBodyPart] = useState<string>(set.body_part ?? "");
  const text = t.sharing.details;
  const save = () =>
    act(async () => {
      onChange(await app.api.sharing.describe(set.id, { title, description, body_part: bodyPart || null }));
      return text.saved;
    });
  return (
    <section class="share-part" aria-label={text.title}>
      <h3>{text.title}</h3>
      <Field label={text.name} value={title} onInput={setTitle} most={80} hint={text.nameHint} />
      <div class="field">
        <label for={`${id}-text`}>{text.text}</label>
        <textarea
          id={`${id}-text`}
          class="prose"
          rows={3}
          maxLength={2000}
          value={description}
          onInput={(event) => setDescription(event.currentTarget.value)}
          aria-describedby={`${id}-hint`}
        />
        <p class="field-hint" id={`${id}-hint`}>
          {text.textHint}
        </p>
      </div>
      <Choice
        label={text.bodyPart}
        value={bodyPart}
        onChoose={setBodyPart}
        options={[["", text.none], ...bodyParts.map((part): [string, string] => [part, t.sharing.parts[part] ?? part])]}
      />
      <p>
        <button type="button" class="button" disabled={busy} onClick={save}>
          {text.save}
        </button>
      </p>
      {outcome}
    </section>
  );
}
