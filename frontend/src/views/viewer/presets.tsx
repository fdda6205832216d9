import { presetNames, type PresetName } from "../../api/types";
import { Modality, type Preset } from "../../protocol/messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { lookColour } from "../../scene/look_colour";
import { useLookPicture } from "../thumbnail";

/** The built-in looks, each as a picture of this scan. */
export function Presets({
  session,
  label = t.viewer.presets,
}: {
  readonly session: ViewerSession;
  readonly label?: string;
}) {
  const presets = session.editor.presets.value;
  const active = session.editor.activePreset();
  if (presets.length === 0) return null;
  return (
    <div class="glass presets" role="region" aria-label={label}>
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
  const { url } = useLookPicture(session.lookPictures, name);
  const colour = lookColour(preset.scene);
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
        {url ? (
          <img src={url} alt="" width={320} height={320} draggable={false} />
        ) : colour ? (
          <Swatch colour={colour} />
        ) : null}
      </span>
      <span class="preset-name">{shown}</span>
    </button>
  );
}

/** Placeholder for a look without a picture, or with one that a guest may not load. */
function Swatch({ colour }: { readonly colour: string }) {
  return (
    <svg class="preset-swatch" viewBox="0 0 44 44" aria-hidden="true">
      <circle cx={22} cy={22} r={15} fill={colour} />
      <circle cx={17} cy={16} r={5} fill="#ffffff" fill-opacity={0.28} />
    </svg>
  );
}
