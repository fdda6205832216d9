import { useRef, useState } from "preact/hooks";
import type { DataSet } from "../../api/types";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Dialog } from "../dialog";
import { Field } from "../field";
import { annotationsToJson } from "../../protocol/mark_messages";
import { IncludeMarks, shownAnnotations } from "../marks/include_marks";
import { Loading } from "../loading";
import { Notice } from "../shell";
import { useApp } from "../state";
import { PresetRow } from "./preset_row";
import { savedText, toPreset } from "./preset_scene";
import { useSavedPresets, type ActOnPresets } from "./use_saved_presets";

export interface SavedPresetsProps {
  readonly session: ViewerSession;
  readonly set: DataSet;
  readonly onClose: () => void;
}

/** The presets that people have saved for this scan. */
export function SavedPresets({ session, set, onClose }: SavedPresetsProps) {
  const { list, message, fault, act, importFile } = useSavedPresets(set);
  const text = t.presets;
  const maySave = set.owned || set.role === "shared-edit" || set.is_public;
  return (
    <Dialog title={text.title} onClose={onClose}>
      <p class="muted">{text.lead}</p>
      {list === null ? <Loading /> : null}
      {list?.length === 0 ? <p>{text.none}</p> : null}
      <ul class="saved-presets" aria-label={text.title}>
        {list?.map((preset) => (
          <PresetRow key={preset.id} preset={preset} session={session} set={set} act={act} />
        ))}
      </ul>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      <p class="muted" role="status">
        {message}
      </p>
      {maySave ? <SaveForm session={session} set={set} act={act} /> : null}
      <div class="dialog-buttons">
        {maySave ? <ImportButton onFile={importFile} /> : null}
        <button type="button" class="button" onClick={onClose}>
          {t.close}
        </button>
      </div>
    </Dialog>
  );
}

interface SaveFormProps extends Pick<SavedPresetsProps, "session" | "set"> {
  readonly act: ActOnPresets;
}

/** Saves the current scene under a name. */
function SaveForm({ session, set, act }: SaveFormProps) {
  const app = useApp();
  const text = t.presets;
  const [name, setName] = useState("");
  const [withMarks, setWithMarks] = useState(false);
  const save = () =>
    act(async () => {
      const scene = session.editor.toSave();
      if (!scene) return "";
      const annotations = withMarks ? annotationsToJson(shownAnnotations(session)) : null;
      await app.api.presets.save(set.id, name.trim(), toPreset(scene), annotations);
      setName("");
      return savedText(name.trim(), scene);
    });
  return (
    <form
      class="share-form"
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        save();
      }}
    >
      <Field label={text.name} value={name} onInput={setName} most={60} hint={text.nameHint} />
      <IncludeMarks session={session} on={withMarks} change={setWithMarks} />
      <button type="submit" class="button button-main" disabled={name.trim() === ""}>
        {text.save}
      </button>
    </form>
  );
}

/** The browser's file input is hidden behind a button in the style of the page. */
function ImportButton({ onFile }: { readonly onFile: (file: File) => void }) {
  const input = useRef<HTMLInputElement>(null);
  return (
    <>
      <input
        ref={input}
        type="file"
        accept=".xml,application/xml,text/xml"
        class="visually-hidden"
        tabIndex={-1}
        aria-label={t.presets.import}
        onChange={(event) => {
          const file = event.currentTarget.files?.[0];
          if (file) onFile(file);
          event.currentTarget.value = ""; // so that the same file can be chosen again
        }}
      />
      <button type="button" class="button" onClick={() => input.current?.click()}>
        {t.presets.import}
      </button>
    </>
  );
}
