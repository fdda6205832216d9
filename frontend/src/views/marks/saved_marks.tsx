import { useState } from "preact/hooks";
import type { AnnotationSet } from "../../api/annotations";
import type { MarkLibrary } from "../../marks/library";
import { annotationsFromJson } from "../../protocol/mark_messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Field } from "../field";
import { useAct } from "../use_act";
import { Switch } from "../viewer/settings/controls";

/** The marks and measurements that are saved with the scan. */
export function SavedMarks({ session }: { readonly session: ViewerSession }) {
  const library = session.library.value;
  const sets = library?.sets.value;
  if (!library || !sets) return null;
  if (!library.saves && sets.length === 0) return null;
  return <Library library={library} sets={sets} />;
}

interface LibraryProps {
  readonly library: MarkLibrary;
  readonly sets: readonly AnnotationSet[];
}

type Act = ReturnType<typeof useAct>["act"];

function Library({ library, sets }: LibraryProps) {
  const { act, busy, outcome } = useAct();
  const text = t.marks.saved;
  return (
    <>
      <h3>{text.title}</h3>
      <p class="hint">{library.saves ? text.lead : text.leadShared}</p>
      <ul class="mark-sets">
        {sets.map((set) => (
          <SetRow key={set.id} library={library} set={set} act={act} />
        ))}
      </ul>
      {library.saves ? <SaveForm library={library} act={act} busy={busy} /> : null}
      {outcome}
      {library.failed.value ? (
        <p class="field-fault" role="alert">
          {t.problems.notTaken}
        </p>
      ) : null}
    </>
  );
}

function SaveForm({
  library,
  act,
  busy,
}: {
  readonly library: MarkLibrary;
  readonly act: Act;
  readonly busy: boolean;
}) {
  const [name, setName] = useState("");
  const text = t.marks.saved;
  const { marks, measures } = library.unsaved();
  if (marks.length + measures.length === 0) return null;
  const save = () =>
    act(async () => {
      await library.add(name.trim());
      setName("");
      return text.added(name.trim());
    });
  return (
    <form
      class="mark-save"
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        save();
      }}
    >
      <p class="hint">{text.unsaved(marks.length, measures.length)}</p>
      <Field label={text.name} value={name} onInput={setName} most={60} />
      <button type="submit" class="button button-main" disabled={busy || name.trim() === ""}>
        {text.save}
      </button>
    </form>
  );
}

interface SetRowProps {
  readonly library: MarkLibrary;
  readonly set: AnnotationSet;
  readonly act: Act;
}

function SetRow({ library, set, act }: SetRowProps) {
  const [asking, setAsking] = useState<"rename" | "remove" | null>(null);
  const text = t.marks.saved;
  const content = annotationsFromJson(set.content);
  const close = () => setAsking(null);
  /** Runs a change that needs no message. */
  const change = (work: () => Promise<void>) => act(() => work().then(() => ""));
  return (
    <li data-set-id={set.id}>
      <Switch
        label={set.name}
        on={library.visible.value.has(set.id)}
        change={(on) => change(() => library.setVisible(set, on))}
      />
      <small class="muted">
        {text.content(content?.marks.length ?? 0, content?.measures.length ?? 0)}
        {set.shared ? `, ${text.shared}` : ""}
      </small>
      {set.mine ? <SetButtons library={library} set={set} change={change} ask={setAsking} /> : null}
      {asking === "rename" ? (
        <RenameForm
          name={set.name}
          rename={(name) => change(() => library.change(set, { name }).then(close))}
          close={close}
        />
      ) : null}
      {asking === "remove" ? (
        <div class="share-form">
          <p role="alert">{text.removeSure(set.name)}</p>
          <button type="button" class="button button-danger" onClick={() => change(() => library.remove(set))}>
            {text.remove}
          </button>
          <button type="button" class="button" onClick={close}>
            {t.cancel}
          </button>
        </div>
      ) : null}
    </li>
  );
}

interface RenameFormProps {
  readonly name: string;
  readonly rename: (name: string) => void;
  readonly close: () => void;
}

function RenameForm({ name: before, rename, close }: RenameFormProps) {
  const [name, setName] = useState(before);
  return (
    <form
      class="share-form"
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        rename(name.trim());
      }}
    >
      <Field label={t.marks.saved.newName} value={name} onInput={setName} most={60} />
      <button type="submit" class="button button-main" disabled={name.trim() === ""}>
        {t.marks.saved.rename}
      </button>
      <button type="button" class="button" onClick={close}>
        {t.cancel}
      </button>
    </form>
  );
}

interface SetButtonsProps extends Pick<SetRowProps, "library" | "set"> {
  readonly change: (work: () => Promise<void>) => void;
  readonly ask: (question: "rename" | "remove") => void;
}

function SetButtons({ library, set, change, ask }: SetButtonsProps) {
  const text = t.marks.saved;
  return (
    <>
      {library.shares ? (
        <>
          <Switch
            label={text.share}
            on={set.shared}
            change={(shared) => change(() => library.change(set, { shared }))}
          />
          {set.shared ? <p class="hint">{text.shareHint}</p> : null}
        </>
      ) : null}
      <p class="saved-acts">
        <button
          type="button"
          class="button button-small"
          aria-label={text.renameOf(set.name)}
          onClick={() => ask("rename")}
        >
          {text.rename}
        </button>
        <button
          type="button"
          class="button button-small"
          aria-label={text.removeOf(set.name)}
          onClick={() => ask("remove")}
        >
          {text.remove}
        </button>
      </p>
    </>
  );
}
