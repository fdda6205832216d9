import { useEffect, useState } from "preact/hooks";
import type { DataSet, PresetInfo } from "../../api/types";
import { Modality } from "../../protocol/messages";
import { comfortLimits } from "../../scene/comfort";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Choice } from "../choice";
import { useApp } from "../state";
import { sceneOfPreset } from "../viewer/preset_scene";
import { NumberControl } from "../viewer/settings/controls";
import type { ViewSettings } from "./view_settings";

export interface LookFieldsProps {
  readonly session: ViewerSession;
  readonly scan: DataSet;
  readonly settings: ViewSettings;
  readonly set: (settings: ViewSettings) => void;
}

/** The look of the picture: a built-in one, or a preset that is saved with the scan. */
export function LookFields({ session, scan, settings, set }: LookFieldsProps) {
  const app = useApp();
  const saved = useSavedLooks(scan.id);
  const [fault, setFault] = useState("");
  const text = t.studies.editor;
  const { editor } = session;
  const names = session.volume.value?.modality === Modality.CT ? t.viewer.lookOfCt : t.viewer.lookOfOther;
  const looks = editor.presets.value;
  const nameOf = (name: string) => names[name] ?? name;
  const active = editor.activePreset()?.name;
  const current = saved.find(({ name }) => name === settings.preset)?.id ?? active ?? "";
  const choose = (value: string) => {
    const look = looks.find(({ name }) => name === value);
    if (look) {
      editor.applyPreset(look);
      set({ ...settings, preset: nameOf(look.name) });
      return;
    }
    const preset = saved.find(({ id }) => id === value);
    if (!preset) return;
    sceneOfPreset(app.api.presets, preset.id).then(
      (scene) => {
        editor.showScene(scene);
        set({ ...settings, preset: preset.name });
        setFault("");
      },
      (thrown: unknown) => setFault(app.explain(thrown)),
    );
  };
  useEffect(() => {
    if (settings.preset === "" && active) set({ ...settings, preset: nameOf(active) });
    // eslint-disable-next-line react-hooks/exhaustive-deps -- only the first look is taken over
  }, [active]);
  return (
    <>
      <Choice
        label={text.look}
        value={current}
        options={[
          ...(current === "" ? [["", text.custom] as const] : []),
          ...looks.map(({ name }) => [name, nameOf(name)] as const),
          ...saved.map(({ id, name }) => [id, text.saved(name)] as const),
        ]}
        onChoose={choose}
      />
      {fault ? <p class="field-fault">{fault}</p> : null}
      {editor.hasComfort() ? (
        <NumberControl
          label={text.comfort}
          value={editor.comfort()}
          limits={comfortLimits}
          step={0.1}
          rest={() => editor.rest()}
          change={(value, held) => editor.setComfort(value, held)}
        />
      ) : null}
    </>
  );
}

/** The presets that are saved with a scan. Those of a sample may not be listed. */
function useSavedLooks(dataSetId: string): readonly PresetInfo[] {
  const app = useApp();
  const [saved, setSaved] = useState<readonly PresetInfo[]>([]);
  useEffect(() => {
    app.api.presets.list(dataSetId).then(setSaved, () => undefined);
  }, [app, dataSetId]);
  return saved;
}
