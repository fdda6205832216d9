import { useEffect, useRef, useState } from "preact/hooks";
import { ApiProblem } from "../../api/client";
import { preset_xml_path } from "../../api/sharing";
import type { DataSet, PresetInfo } from "../../api/types";
import { scene_to_json } from "../../protocol/messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Dialog } from "../dialog";
import { Field } from "../field";
import { Icon } from "../icons";
import { ReportDialog } from "../report_dialog";
import { Notice } from "../shell";
import { useApp } from "../state";
import { PresetPicture } from "../thumbnail";
import { scene_of_preset } from "./preset_scene";

const most_file_bytes = 256 * 1024;

export interface SavedPresetsProps {
  readonly session: ViewerSession;
  readonly set: DataSet;
  readonly onClose: () => void;
}

/** Looks that people saved for this scan: one's own and other people's. */
export function SavedPresets({ session, set, onClose }: SavedPresetsProps) {
  const app = useApp();
  const [list, set_list] = useState<readonly PresetInfo[] | null>(null);
  const [name, set_name] = useState("");
  const [said, set_said] = useState("");
  const [fault, set_fault] = useState("");
  const file = useRef<HTMLInputElement>(null);
  const text = t.presets;
  const may_save = set.owned || set.role === "shared-edit" || set.is_public;

  const reload = async () => set_list(await app.api.presets.list(set.id));
  useEffect(() => {
    reload().catch((thrown: unknown) => set_fault(app.explain(thrown)));
  }, [app, set.id]);

  const act = (work: () => Promise<string>) => {
    set_said("");
    set_fault("");
    void work().then(set_said, (thrown: unknown) => {
      const stale = thrown instanceof ApiProblem && thrown.status === 412;
      set_fault(stale ? text.changed : app.explain(thrown));
    }).then(reload).catch(() => undefined);
  };
  const current = (): object | null => (session.scene.value ? (JSON.parse(scene_to_json(session.scene.value)) as object) : null);
  const save = () => act(async () => {
    const scene = current();
    if (!scene) return "";
    await app.api.presets.save(set.id, name.trim(), scene);
    set_name("");
    return text.saved(name.trim());
  });
  const import_file = (chosen: File | undefined) => {
    if (!chosen) return;
    act(async () => {
      if (chosen.size > most_file_bytes) return text.too_large;
      return text.saved((await app.api.presets.import_xml(set.id, chosen)).name);
    });
  };
  return (
    <Dialog title={text.title} onClose={onClose}>
      <p class="muted">{text.lead}</p>
      {list === null ? <p class="muted" role="status">{t.loading}</p> : null}
      {list?.length === 0 ? <p>{text.none}</p> : null}
      <ul class="saved-presets" aria-label={text.title}>
        {list?.map((preset) => <PresetRow key={preset.id} preset={preset} session={session} set={set} act={act} current={current} />)}
      </ul>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      <p class="muted" role="status">{said}</p>
      {may_save ? (
        <form class="share-form" noValidate onSubmit={(event) => {
          event.preventDefault();
          save();
        }}>
          <Field label={text.name} value={name} onInput={set_name} most={60} />
          <button type="submit" class="button button-main" disabled={name.trim() === ""}>{text.save}</button>
        </form>
      ) : null}
      <div class="dialog-buttons">
        {may_save ? (
          <>
            <input ref={file} type="file" accept=".xml,application/xml,text/xml" class="visually-hidden" tabIndex={-1} aria-label={text.import} onChange={(event) => {
              import_file(event.currentTarget.files?.[0]);
              event.currentTarget.value = "";
            }} />
            <button type="button" class="button" onClick={() => file.current?.click()}>{text.import}</button>
          </>
        ) : null}
        <button type="button" class="button" onClick={onClose}>{t.close}</button>
      </div>
    </Dialog>
  );
}

interface PresetRowProps {
  readonly preset: PresetInfo;
  readonly session: ViewerSession;
  readonly set: DataSet;
  readonly act: (work: () => Promise<string>) => void;
  readonly current: () => object | null;
}

function PresetRow({ preset, session, set, act, current }: PresetRowProps) {
  const app = useApp();
  const [asking, set_asking] = useState<"rename" | "remove" | "report" | null>(null);
  const [name, set_name] = useState(preset.name);
  const text = t.presets;
  const api = app.api.presets;
  const apply = () => act(async () => {
    session.show_scene(await scene_of_preset(api, preset.id));
    return "";
  });
  const vote = (value: -1 | 1) => act(async () => {
    await api.vote(preset, preset.my_vote === value ? 0 : value);
    return "";
  });
  const rename = () => act(async () => {
    await api.change(preset, { name: name.trim() });
    set_asking(null);
    return text.done;
  });
  const overwrite = () => act(async () => {
    const scene = current();
    if (scene) await api.change(preset, { scene });
    return text.saved(preset.name);
  });
  const remove = () => act(async () => {
    await api.remove(preset);
    return text.done;
  });
  const set_default = () => act(async () => {
    await api.set_default(set.id, preset.is_default ? null : preset);
    return text.done;
  });
  const update_default = () => act(async () => {
    await api.set_default(set.id, preset);
    return text.done;
  });
  const small = (label: string, of: string, onClick: () => void) => (
    <button type="button" class="button button-small" aria-label={of} onClick={onClick}>{label}</button>
  );
  return (
    <li data-preset-id={preset.id}>
      <div class="saved-head">
        <PresetPicture preset={preset} />
        <button type="button" class="saved-name" aria-label={text.apply(preset.name)} onClick={apply}>{preset.name}</button>
        {preset.is_default ? <span class="chip chip-accent">{text.is_default}</span> : null}
        <small class="muted">{preset.mine ? text.mine : preset.author_name ? text.by(preset.author_name) : ""}</small>
        {set.is_public ? (
          <span class="votes">
            <button type="button" class="icon-button" aria-label={text.vote_up(preset.name)} aria-pressed={preset.my_vote === 1} onClick={() => vote(1)}><Icon name="up" /></button>
            <span>{text.votes(preset.votes)}</span>
            <button type="button" class="icon-button" aria-label={text.vote_down(preset.name)} aria-pressed={preset.my_vote === -1} onClick={() => vote(-1)}><Icon name="down" /></button>
          </span>
        ) : null}
      </div>
      {preset.taken_down ? <Notice kind="bad">{text.taken_down(preset.taken_down.reason)}</Notice> : null}
      <div class="saved-acts">
        {preset.mine ? small(text.rename, text.rename_of(preset.name), () => set_asking("rename")) : null}
        {preset.mine ? small(text.overwrite, text.overwrite_of(preset.name), overwrite) : null}
        {set.owned ? small(preset.is_default ? text.unset_default : text.set_default, (preset.is_default ? text.unset_default_of : text.set_default_of)(preset.name), set_default) : null}
        {set.owned && preset.changed_since_default ? small(text.update_default, text.update_default_of(preset.name), update_default) : null}
        <a class="button button-small" href={preset_xml_path(preset.id)} download={`${preset.name}.xml`} aria-label={text.export_of(preset.name)}>{text.export}</a>
        {set.is_public && !set.owned && !preset.mine ? small(text.report, text.report_of(preset.name), () => set_asking("report")) : null}
        {preset.mine || set.owned ? small(text.remove, text.remove_of(preset.name), () => set_asking("remove")) : null}
      </div>
      {asking === "rename" ? (
        <form class="share-form" onSubmit={(event) => {
          event.preventDefault();
          rename();
        }}>
          <Field label={text.new_name} value={name} onInput={set_name} most={60} />
          <button type="submit" class="button button-main" disabled={name.trim() === ""}>{text.rename}</button>
          <button type="button" class="button" onClick={() => set_asking(null)}>{t.cancel}</button>
        </form>
      ) : null}
      {asking === "report" ? (
        <ReportDialog title={t.sharing.report.title_preset(preset.name)} reasons={t.sharing.report.reasons_preset} onClose={() => set_asking(null)}
          send={(reason, words) => api.report(preset.id, reason, words)} />
      ) : null}
      {asking === "remove" ? (
        <div class="share-form">
          <p role="alert">{text.remove_sure(preset.name)}</p>
          <button type="button" class="button button-danger" onClick={remove}>{text.remove}</button>
          <button type="button" class="button" onClick={() => set_asking(null)}>{t.cancel}</button>
        </div>
      ) : null}
    </li>
  );
}

const look = /^#look=([0-9a-f-]{36})$/;

/** The address may say with which preset the scan is to be shown: a link of the gallery. */
export function WantedPreset({ session }: { readonly session: ViewerSession }) {
  const app = useApp();
  const ready = session.scene.value !== null;
  useEffect(() => {
    const wanted = ready ? look.exec(location.hash)?.[1] : undefined;
    if (wanted === undefined) return;
    history.replaceState(null, "", location.pathname); // a reload shows what the picture has become since
    scene_of_preset(app.api.presets, wanted).then((scene) => session.show_scene(scene), () => undefined); // the picture is there without it
  }, [app, session, ready]);
  return null;
}
