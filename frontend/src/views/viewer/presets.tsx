import { presetNames, type PresetName } from "../../api/types";
import { Modality, type Preset } from "../../protocol/messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { useThumbnail } from "../thumbnail";

/** The built-in looks, each as a picture of this scan. */
export function Presets({ session }: { readonly session: ViewerSession }) {
  const presets = session.editor.presets.value;
  const active = session.editor.activePreset();
  if (presets.length === 0) return null;
  return (
    <div class="glass presets" role="region" aria-label={t.viewer.presets}>
      {presets.map((preset, i) => (
        <PresetButton key={preset.name} session={session} preset={preset} digit={i + 1} pressed={preset === active} />
      ))}
    </div>
  );
}

interface PresetButtonProps {
  readonly session: ViewerSession;
  readonly preset: Preset;
  readonly digit: number;
  readonly pressed: boolean;
}

const isKnown = (name: string): name is PresetName => (presetNames as readonly string[]).includes(name);

function PresetButton({ session, preset, digit, pressed }: PresetButtonProps) {
  const name = isKnown(preset.name) ? preset.name : null;
  const isCt = session.volume.value?.modality === Modality.CT;
  const shown = (isCt ? t.viewer.lookOfCt : t.viewer.lookOfOther)[preset.name] ?? preset.name;
  const url = useThumbnail(session.dataSetId ?? "", name ?? "skin", name !== null && session.dataSetId !== null);
  return (
    <button
      type="button"
      class="preset"
      aria-pressed={pressed}
      aria-keyshortcuts={String(digit)}
      data-preset={preset.name}
      onClick={() => session.editor.applyPreset(preset)}
    >
      <span class="preset-picture">
        {url ? <img src={url} alt="" width={320} height={320} draggable={false} /> : null}
      </span>
      <span class="preset-name">{shown}</span>
    </button>
  );
}
