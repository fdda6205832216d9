import type { Channel } from "../../../protocol/gen/api/proto/scene_pb";
import { hueOf, scaled, strengthOf } from "../../../scene/colour";
import * as transfer from "../../../scene/transfer";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { ColourControl, NameControl, NumberControl } from "./controls";

export interface MaterialControlsProps {
  readonly session: ViewerSession;
  /** The material's channel in the transfer function. */
  readonly index: number;
  readonly onRemoved: () => void;
}

interface MaterialPartProps {
  readonly channel: Channel;
  readonly set: (what: string, material: transfer.Material, held: boolean) => void;
  readonly rest: () => void;
}

/** The properties of a material besides its colour. */
export function MaterialControls({ session, index, onRemoved }: MaterialControlsProps) {
  const text = t.settings.look;
  const channels = session.editor.scene.value ? transfer.channelsOf(session.editor.scene.value) : [];
  const channel = channels[index];
  if (!channel) return null;
  const rest = () => session.editor.rest();
  const set = (what: string, material: transfer.Material, held: boolean) =>
    session.editor.change(`${what} ${index}`, (now) => transfer.setMaterial(now, index, material), held);
  const remove = () => {
    session.editor.change("channel removed", (now) => transfer.removeChannel(now, index));
    rest();
    onRemoved();
  };
  return (
    <>
      <NameControl
        label={text.name}
        value={t.settings.nameOf(channel.name)}
        most={transfer.longestName}
        change={(name) => {
          set("name", { name }, false);
          rest();
        }}
      />
      <SurfaceControls channel={channel} set={set} rest={rest} />
      <GlowControls channel={channel} set={set} rest={rest} />
      {channels.length > 1 ? (
        <p>
          <button type="button" class="button button-small" onClick={remove}>
            {text.remove(text.channel(channel.name, index + 1))}
          </button>
        </p>
      ) : null}
    </>
  );
}

function SurfaceControls({ channel, set, rest }: MaterialPartProps) {
  const text = t.settings.look;
  return (
    <>
      <ColourControl
        label={text.highlight}
        value={channel.specular}
        rest={rest}
        change={(specular, held) => set("highlight", { specular }, held)}
      />
      <NumberControl
        label={text.gloss}
        value={channel.gloss}
        limits={transfer.unitLimits}
        step={0.01}
        rest={rest}
        change={(gloss, held) => set("gloss", { gloss }, held)}
      />
      <p class="hint">{text.surfaceHint}</p>
    </>
  );
}

/** The emission as a hue and a strength. A material that begins to glow takes the hue of its colour. */
function GlowControls({ channel, set, rest }: MaterialPartProps) {
  const text = t.settings.look;
  const glow = strengthOf(channel.emission);
  return (
    <>
      <NumberControl
        label={text.glow}
        value={glow}
        limits={transfer.emissionLimits}
        slide={{ low: 0, high: 10 }}
        step={0.05}
        rest={rest}
        change={(strength, held) =>
          set("glow", { emission: scaled(hueOf(glow > 0 ? channel.emission : channel.diffuse), strength) }, held)
        }
      />
      {glow > 0 ? (
        <ColourControl
          label={text.glowColour}
          value={hueOf(channel.emission)}
          rest={rest}
          change={(hue, held) => set("glow colour", { emission: scaled(hueOf(hue), glow) }, held)}
        />
      ) : null}
    </>
  );
}
