import { preset_names, type PresetName } from "../../api/types";
import type { Preset } from "../../protocol/messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { use_thumbnail } from "../thumbnail";

/** The looks to choose from, each as a picture of this very scan. */
export function Presets({ session }: { readonly session: ViewerSession }) {
  const presets = session.presets.value;
  const active = session.active_preset();
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

const is_known = (name: string): name is PresetName => (preset_names as readonly string[]).includes(name);

function PresetButton({ session, preset, digit, pressed }: PresetButtonProps) {
  const name = is_known(preset.name) ? preset.name : null;
  const url = use_thumbnail(session.data_set_id ?? "", name ?? "skin", name !== null && session.data_set_id !== null);
  return (
    <button
      type="button"
      class="preset"
      aria-pressed={pressed}
      aria-keyshortcuts={String(digit)}
      data-preset={preset.name}
      onClick={() => session.apply_preset(preset)}
    >
      <span class="preset-picture">{url ? <img src={url} alt="" width={320} height={320} draggable={false} /> : null}</span>
      <span class="preset-name">{t.viewer.preset[preset.name] ?? preset.name}</span>
    </button>
  );
}
