import type { Role } from "../../live/role";
import { phaseOf, phaseRates } from "../../scene/phases";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { IconButton } from "../icon_button";
import { Icon } from "../icons";
import { phaseText } from "./phase_text";

export interface PhaseLineProps {
  readonly session: ViewerSession;
  readonly role: Role;
}

/** The phase of the scan that is shown, and the controls with which the presenter chooses and plays phases. */
export function PhaseLine({ session, role }: PhaseLineProps) {
  const phases = session.phases.phases.value;
  const scene = session.editor.scene.value;
  const picture = session.pictures.picture.value;
  if (phases.length < 2 || !scene || !picture) return null;
  const chosen = phaseOf(scene, phases.length);
  const playing = session.phases.playing.value;
  // While phases are played, the picture may lag behind.
  const shown = playing || !role.presents ? Math.min(picture.phase, phases.length - 1) : chosen;
  const text = phaseText(phases, shown);
  return (
    <section class="glass phase-line" aria-label={t.phases.title} data-playing={playing ? "" : undefined}>
      {role.presents ? <PhaseControls session={session} chosen={chosen} /> : null}
      <span class="phase-text" style={{ minWidth: `${widest(session)}ch` }}>
        {text}
      </span>
      {role.presents ? <Speed session={session} /> : null}
      <LoadingNote session={session} />
    </section>
  );
}

/** Returns the length of the longest label, so that nothing moves while phases are played. */
function widest(session: ViewerSession): number {
  const phases = session.phases.phases.value;
  return Math.max(...phases.map((_, index) => phaseText(phases, index).length));
}

function PhaseControls({ session, chosen }: { readonly session: ViewerSession; readonly chosen: number }) {
  const player = session.phases;
  const phases = player.phases.value;
  const playing = player.playing.value;
  return (
    <>
      <IconButton
        class="phase-play"
        icon={playing ? "pause" : "play"}
        label={playing ? t.phases.pause : t.phases.play}
        onClick={() => player.toggle()}
      />
      <input
        type="range"
        class="phase-slider"
        aria-label={t.phases.choose}
        aria-valuetext={phaseText(phases, chosen)}
        min={0}
        max={phases.length - 1}
        step={1}
        value={chosen}
        onInput={(event) => player.choose(Number(event.currentTarget.value), true)}
        onChange={() => session.editor.rest()}
      />
    </>
  );
}

function Speed({ session }: Pick<PhaseLineProps, "session">) {
  const player = session.phases;
  const repeats = player.repeats.value;
  return (
    <span class="phase-speed">
      <select
        class="choice"
        aria-label={t.phases.rate}
        title={t.phases.rate}
        value={String(player.rate.value)}
        onChange={(event) => player.setRate(Number(event.currentTarget.value))}
      >
        {phaseRates.map((rate) => (
          <option key={rate} value={String(rate)}>
            {t.phases.perSecond(rate)}
          </option>
        ))}
      </select>
      <button
        type="button"
        class="icon-button phase-repeat"
        aria-label={t.phases.repeat}
        title={t.phases.repeat}
        aria-pressed={repeats}
        onClick={() => (player.repeats.value = !repeats)}
      >
        <Icon name="repeat" />
      </button>
    </span>
  );
}

/** Says why phases are not played smoothly yet, or never. */
function LoadingNote({ session }: Pick<PhaseLineProps, "session">) {
  const loaded = session.phases.loaded.value;
  const count = session.phases.phases.value.length;
  if (!loaded || loaded.loaded >= count) return null;
  return (
    <p class="phase-note" role="status">
      {loaded.fit ? t.phases.loading(loaded.loaded, count) : t.phases.tooMany}
    </p>
  );
}
