import { Shading_Mode, type Scene } from "../../../protocol/gen/api/proto/scene_pb";
import * as lens from "../../../scene/lens";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Icon } from "../../icons";
import type { Picking } from "../../picture/in_picture";
import { ColourControl, NumberControl, Switch, type PictureWindowProps } from "./controls";
import { EffortPart } from "./effort_part";

const modes = [["phase", Shading_Mode.PHASE], ["surface", Shading_Mode.SURFACE], ["hybrid", Shading_Mode.HYBRID]] as const;

/** How the picture is taken, and how much work is put into it. */
export function LensWindow({ session, picture }: PictureWindowProps) {
  const text = t.settings.lens;
  const scene = session.scene.value;
  if (!scene?.camera) return null;
  const rest = () => session.rest();
  const now = <Value,>(what: string, edit: (before: Scene, value: Value) => Scene) =>
    (value: Value, held: boolean) => session.change(what, (before) => edit(before, value), held);
  const once = <Value,>(what: string, edit: (before: Scene, value: Value) => Scene) => (value: Value) => {
    session.change(what, (before) => edit(before, value));
    rest();
  };
  const focus = lens.focus_of(scene);
  const parallel = lens.is_orthographic(scene);
  const mode = lens.mode_of(scene);
  return (
    <>
      <NumberControl label={text.exposure} unit={text.stops} value={scene.display?.exposure ?? 0} limits={lens.exposure_limits} slide={{ low: -4, high: 4 }} step={0.1}
        rest={rest} change={now("exposure", lens.set_exposure)} />
      <ColourControl label={text.background} value={scene.display?.background} rest={rest} change={now("background", lens.set_background)} />
      <NumberControl label={text.aperture} unit={t.settings.mm} value={scene.camera.apertureRadius} limits={lens.aperture_limits} slide={{ low: 0, high: 40 }} step={0.2}
        rest={rest} change={now("aperture", lens.set_aperture)} />
      <p><button type="button" class="button button-small" aria-pressed={picture.picking.value !== null} onClick={() => {
        picture.picking.value = picture.picking.value ? null : focus_picking(session);
      }}><Icon name="aperture" />{text.pick}</button></p>
      <Switch label={text.focus_middle} on={focus.middle} change={(middle) => once("focus", lens.set_focus)(middle ? null : Math.round(focus.distance))} />
      {focus.middle ? null : (
        <NumberControl label={text.focus} unit={t.settings.mm} value={focus.distance} limits={lens.focus_limits} slide={{ low: 10, high: 3000 }} logarithmic
          rest={rest} change={now("focus", lens.set_focus)} />
      )}
      <details class="more">
        <summary>{t.settings.more}</summary>
        <label class="control">
          <span class="control-name">{text.projection}</span>
          <select class="choice" value={parallel ? "parallel" : "perspective"} onChange={(event) => once("projection", lens.set_orthographic)(event.currentTarget.value === "parallel")}>
            <option value="perspective">{text.perspective}</option>
            <option value="parallel">{text.orthographic}</option>
          </select>
        </label>
        {parallel ? null : (
          <NumberControl label={text.fov} unit={t.settings.degrees} value={scene.camera.verticalFovDegrees} limits={lens.fov_limits} rest={rest} change={now("fov", lens.set_fov)} />
        )}
        <NumberControl label={text.bounces} value={lens.bounces_of(scene)} limits={lens.bounces_limits} slide={{ low: 1, high: 64 }} logarithmic rest={rest}
          change={now("bounces", lens.set_bounces)} />
        <p class="hint">{text.bounces_hint}</p>
        <label class="control">
          <span class="control-name">{text.shading}</span>
          <select class="choice" value={modes.find(([, one]) => one === mode)?.[0] ?? "phase"} onChange={(event) => {
            const chosen = modes.find(([name]) => name === event.currentTarget.value);
            if (chosen) once("shading", lens.set_mode)(chosen[1]);
          }}>
            {modes.map(([name]) => <option key={name} value={name}>{text.shadings[name]}</option>)}
          </select>
        </label>
        {mode === Shading_Mode.HYBRID ? (
          <NumberControl label={text.gradient} unit={t.settings.look.per_mm} value={lens.gradient_of(scene)} limits={lens.gradient_limits} logarithmic rest={rest}
            change={now("gradient", lens.set_gradient)} />
        ) : null}
        {mode === Shading_Mode.SURFACE ? null : (
          <NumberControl label={text.forward} value={scene.phase?.g ?? 0} limits={lens.forward_limits} step={0.01} rest={rest} change={now("forward", lens.set_forward)} />
        )}
        <Switch label={text.environment} on={scene.display?.showEnvironment ?? false} change={once("environment", lens.show_environment)} />
        <EffortPart session={session} />
      </details>
    </>
  );
}

/** Sharp where somebody presses. */
function focus_picking(session: ViewerSession): Picking {
  const text = t.settings.lens;
  return {
    label: text.pick_label,
    pick: async ({ x, y }) => {
      const answer = await session.depth_at(x, y);
      if (!answer.answered) return text.pick_lost;
      if (!answer.seen) return text.pick_nothing;
      const { distance } = answer.seen;
      session.change("focus picked", (before) => lens.focus_at(before, distance));
      session.rest();
      return null;
    },
  };
}
