import { useState } from "preact/hooks";
import { presetXmlPath } from "../../api/sharing";
import type { DataSet, PresetInfo } from "../../api/types";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Field } from "../field";
import { Icon } from "../icons";
import { ReportDialog } from "../report_dialog";
import { Notice } from "../shell";
import { useApp } from "../state";
import { PresetPicture } from "../thumbnail";
import { savedText, showPreset, toPreset } from "./preset_scene";
import type { ActOnPresets } from "./use_saved_presets";

export interface PresetRowProps {
  readonly preset: PresetInfo;
  readonly session: ViewerSession;
  readonly set: DataSet;
  readonly act: ActOnPresets;
}

type Question = "rename" | "remove" | "report";
type PresetActions = ReturnType<typeof usePresetActions>;

/** A saved preset and the user's possible actions on it. */
export function PresetRow(props: PresetRowProps) {
  const { preset } = props;
  const { api } = useApp();
  const [asking, setAsking] = useState<Question | null>(null);
  const [name, setName] = useState(preset.name);
  const actions = usePresetActions(props);
  const close = () => setAsking(null);
  return (
    <li data-preset-id={preset.id}>
      <PresetHead preset={preset} voting={props.set.is_public} actions={actions} />
      {preset.taken_down ? <Notice kind="bad">{t.presets.takenDown(preset.taken_down.reason)}</Notice> : null}
      <PresetButtons preset={preset} set={props.set} actions={actions} ask={setAsking} />
      {asking === "rename" ? (
        <RenameForm name={name} onInput={setName} rename={() => actions.rename(name, close)} onClose={close} />
      ) : null}
      {asking === "report" ? (
        <ReportDialog
          title={t.sharing.report.titlePreset(preset.name)}
          reasons={t.sharing.report.reasonsPreset}
          onClose={close}
          send={(reason, words) => api.presets.report(preset.id, reason, words)}
        />
      ) : null}
      {asking === "remove" ? <RemoveQuestion preset={preset} remove={actions.remove} onClose={close} /> : null}
    </li>
  );
}

function usePresetActions({ preset, session, set, act }: PresetRowProps) {
  const api = useApp().api.presets;
  const text = t.presets;
  /** Runs a change and shows `text.done` afterwards. */
  const change = (work: () => Promise<unknown>) =>
    act(async () => {
      await work();
      return text.done;
    });
  return {
    apply: () =>
      act(async () => {
        await showPreset(api, preset.id, session);
        return "";
      }),
    /** Votes for or against the preset. Repeating a vote removes it. */
    vote: (value: -1 | 1) =>
      act(async () => {
        await api.vote(preset, preset.my_vote === value ? 0 : value);
        return "";
      }),
    rename: (name: string, done: () => void) => change(() => api.change(preset, { name: name.trim() }).then(done)),
    overwrite: () =>
      act(async () => {
        const scene = session.editor.toSave();
        if (!scene) return "";
        await api.change(preset, { scene: toPreset(scene) });
        return savedText(preset.name, scene);
      }),
    remove: () => change(() => api.remove(preset)),
    toggleDefault: () => change(() => api.setDefault(set.id, preset.is_default ? null : preset)),
    updateDefault: () => change(() => api.setDefault(set.id, preset)),
  };
}

interface PresetHeadProps {
  readonly preset: PresetInfo;
  readonly voting: boolean;
  readonly actions: PresetActions;
}

function PresetHead({ preset, voting, actions }: PresetHeadProps) {
  const text = t.presets;
  return (
    <div class="saved-head">
      <PresetPicture preset={preset} />
      <button type="button" class="saved-name" aria-label={text.apply(preset.name)} onClick={actions.apply}>
        {preset.name}
      </button>
      {preset.is_default ? <span class="chip chip-accent">{text.isDefault}</span> : null}
      <small class="muted">{preset.mine ? text.mine : preset.author_name ? text.by(preset.author_name) : ""}</small>
      {voting ? <Votes preset={preset} vote={actions.vote} /> : null}
    </div>
  );
}

function Votes({ preset, vote }: { readonly preset: PresetInfo; readonly vote: PresetActions["vote"] }) {
  const text = t.presets;
  return (
    <span class="votes">
      <button
        type="button"
        class="icon-button"
        aria-label={text.voteUp(preset.name)}
        aria-pressed={preset.my_vote === 1}
        onClick={() => vote(1)}
      >
        <Icon name="up" />
      </button>
      <span>{text.votes(preset.votes)}</span>
      <button
        type="button"
        class="icon-button"
        aria-label={text.voteDown(preset.name)}
        aria-pressed={preset.my_vote === -1}
        onClick={() => vote(-1)}
      >
        <Icon name="down" />
      </button>
    </span>
  );
}

interface PresetButtonsProps {
  readonly preset: PresetInfo;
  readonly set: DataSet;
  readonly actions: PresetActions;
  readonly ask: (question: Question) => void;
}

function PresetButtons({ preset, set, actions, ask }: PresetButtonsProps) {
  const text = t.presets;
  const { name } = preset;
  return (
    <div class="saved-acts">
      {preset.mine ? <Small label={text.rename} of={text.renameOf(name)} onClick={() => ask("rename")} /> : null}
      {preset.mine ? <Small label={text.overwrite} of={text.overwriteOf(name)} onClick={actions.overwrite} /> : null}
      {set.owned ? (
        <Small
          label={preset.is_default ? text.unsetDefault : text.setDefault}
          of={(preset.is_default ? text.unsetDefaultOf : text.setDefaultOf)(name)}
          onClick={actions.toggleDefault}
        />
      ) : null}
      {set.owned && preset.changed_since_default ? (
        <Small label={text.updateDefault} of={text.updateDefaultOf(name)} onClick={actions.updateDefault} />
      ) : null}
      <a
        class="button button-small"
        href={presetXmlPath(preset.id)}
        download={`${name}.xml`}
        aria-label={text.exportOf(name)}
      >
        {text.export}
      </a>
      {set.is_public && !set.owned && !preset.mine ? (
        <Small label={text.report} of={text.reportOf(name)} onClick={() => ask("report")} />
      ) : null}
      {preset.mine || set.owned ? (
        <Small label={text.remove} of={text.removeOf(name)} onClick={() => ask("remove")} />
      ) : null}
    </div>
  );
}

interface SmallProps {
  readonly label: string;
  /** The accessible name, which includes the preset's name. */
  readonly of: string;
  readonly onClick: () => void;
}

function Small({ label, of, onClick }: SmallProps) {
  return (
    <button type="button" class="button button-small" aria-label={of} onClick={onClick}>
      {label}
    </button>
  );
}

interface RenameFormProps {
  readonly name: string;
  readonly onInput: (name: string) => void;
  readonly rename: () => void;
  readonly onClose: () => void;
}

function RenameForm({ name, onInput, rename, onClose }: RenameFormProps) {
  return (
    <form
      class="share-form"
      onSubmit={(event) => {
        event.preventDefault();
        rename();
      }}
    >
      <Field label={t.presets.newName} value={name} onInput={onInput} most={60} hint={t.presets.nameHint} />
      <button type="submit" class="button button-main" disabled={name.trim() === ""}>
        {t.presets.rename}
      </button>
      <button type="button" class="button" onClick={onClose}>
        {t.cancel}
      </button>
    </form>
  );
}

interface RemoveQuestionProps {
  readonly preset: PresetInfo;
  readonly remove: () => void;
  readonly onClose: () => void;
}

function RemoveQuestion({ preset, remove, onClose }: RemoveQuestionProps) {
  return (
    <div class="share-form">
      <p role="alert">{t.presets.removeSure(preset.name)}</p>
      <button type="button" class="button button-danger" onClick={remove}>
        {t.presets.remove}
      </button>
      <button type="button" class="button" onClick={onClose}>
        {t.cancel}
      </button>
    </div>
  );
}
