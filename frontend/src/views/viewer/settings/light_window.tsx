import { bounds_of } from "../../../cut/region";
import type { Light } from "../../../protocol/gen/api/proto/scene_pb";
import { camera_of } from "../../../protocol/messages";
import { hex_of, hue_of } from "../../../scene/colour";
import { reach_of } from "../../../scene/cuts";
import { show_environment } from "../../../scene/lens";
import * as lights from "../../../scene/lights";
import { is_sky } from "../../../scene/textures";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Icon } from "../../icons";
import { ColourControl, KeepHandles, NumberControl, Switch, type PictureWindowProps } from "./controls";
import { LightBall } from "./light_ball";
import { TexturePart, type TexturePartProps } from "./texture_part";

const kinds = ["rectangle", "disk", "sphere", "environment"] as const;

/** Lights: where each comes from and how bright it is first; the rest behind "More". */
export function LightWindow({ session, leads, picture }: PictureWindowProps) {
  const text = t.settings.light;
  const scene = session.scene.value;
  const volume = session.volume.value;
  if (!scene) return null;
  const index = Math.min(picture.light.value, scene.lights.length - 1);
  const choose = (which: number) => (picture.light.value = which);
  const light = scene.lights[index];
  const rest = () => session.rest();
  const add = (kind: string) => {
    const shape = kinds.find((one) => one === kind);
    if (!shape) return;
    const radius = volume ? reach_of(bounds_of(volume)) : 200;
    session.change("light added", (now) => lights.add_light(now, shape, text.names[shape], radius));
    rest();
    choose(scene.lights.length);
  };
  return (
    <>
      <div class="channels" role="group" aria-label={text.lights}>
        {scene.lights.map((one, i) => {
          const name = text.light(one.name, i + 1);
          return (
            <span key={i} class="channel" data-light={i}>
              <input type="checkbox" aria-label={text.on(name)} checked={!one.disabled} onChange={(event) => {
                const off = !event.currentTarget.checked;
                session.change(`light on ${i}`, (now) => lights.switch_light(now, i, off));
                rest();
              }} />
              <button type="button" aria-pressed={i === index} onClick={() => choose(i)}>
                <svg class="swatch" viewBox="0 0 10 10" aria-hidden="true"><circle cx="5" cy="5" r="4.500" fill={hex_of(hue_of(lights.radiance_of(one)))} /></svg>
                {name}
              </button>
            </span>
          );
        })}
      </div>
      <KeepHandles picture={picture} which="light" />
      {light ? <OneLight session={session} leads={leads} picture={picture} light={light} index={index} /> : <p class="hint">{text.none}</p>}
      <label class="control">
        <span class="control-name">{text.add}</span>
        <select class="choice" value="" disabled={scene.lights.length >= lights.most_lights} onChange={(event) => {
          add(event.currentTarget.value);
          event.currentTarget.value = "";
        }}>
          <option value="">…</option>
          {kinds.map((kind) => <option key={kind} value={kind}>{text.kinds[kind]}</option>)}
        </select>
      </label>
    </>
  );
}

interface OneLightProps extends PictureWindowProps {
  readonly light: Light;
  readonly index: number;
}

function OneLight({ session, leads, picture, light, index }: OneLightProps) {
  const text = t.settings.light;
  const place = lights.place_of(light);
  const rest = () => session.rest();
  const move = (to: Partial<lights.Place>, held: boolean) => session.change(`light place ${index}`, (now) => lights.place_light(now, index, to), held);
  return (
    <>
      {place ? (
        <div class="ball-row">
          <LightBall direction={place} others={others_of(session, light)} leads={leads} change={move} rest={rest} />
          <p class="hint">{light.cameraLocked ? text.ball_from.camera : text.ball_from.patient}. {t.settings.picture.light}</p>
        </div>
      ) : null}
      <NumberControl label={text.brightness} value={lights.intensity_of(light)} limits={lights.intensity_limits} slide={{ low: 0.05, high: 20 }} logarithmic rest={rest}
        change={(to, held) => session.change(`light brightness ${index}`, (now) => lights.dim_light(now, index, to), held)} />
      <ColourControl label={text.colour} value={hue_of(lights.radiance_of(light))} rest={rest}
        change={(hue, held) => session.change(`light colour ${index}`, (now) => lights.colour_light(now, index, hue), held)} />
      <details class="more">
        <summary>{t.settings.more}</summary>
        {place ? <Numbers session={session} leads={leads} picture={picture} light={light} index={index} /> : null}
        <Locked session={session} light={light} index={index} />
        {is_sky(light) ? (
          <Switch label={t.settings.lens.environment} on={session.scene.value?.display?.showEnvironment ?? false} change={(on) => {
            session.change("environment", (now) => show_environment(now, on));
            rest();
          }} />
        ) : null}
        <TexturePart session={session} light={light} index={index} />
        <label class="control">
          <span class="control-name">{text.name}</span>
          <input type="text" class="name" maxLength={60} value={light.name} onChange={(event) => {
            const name = event.currentTarget.value.trim();
            session.change(`light name ${index}`, (now) => lights.name_light(now, index, name));
            rest();
          }} />
        </label>
        <p><button type="button" class="button button-small" onClick={() => {
          session.change("light removed", (now) => lights.remove_light(now, index));
          rest();
        }}><Icon name="trash" />{text.remove(text.light(light.name, index + 1))}</button></p>
      </details>
    </>
  );
}

function Numbers({ session, light, index }: OneLightProps) {
  const text = t.settings.light;
  const place = lights.place_of(light);
  const size = lights.size_of(light);
  const rest = () => session.rest();
  const move = (to: Partial<lights.Place>, held: boolean) => session.change(`light place ${index}`, (now) => lights.place_light(now, index, to), held);
  if (!place || size === null) return null;
  return (
    <>
      <NumberControl label={text.right} unit={t.settings.degrees} value={place.right} limits={lights.turn_limits} rest={rest} change={(right, held) => move({ right }, held)} />
      <NumberControl label={text.up} unit={t.settings.degrees} value={place.up} limits={lights.tilt_limits} rest={rest} change={(up, held) => move({ up }, held)} />
      <NumberControl label={text.distance} unit={t.settings.mm} value={place.distance} limits={lights.distance_limits} logarithmic rest={rest}
        change={(distance, held) => move({ distance }, held)} />
      <NumberControl label={text.size} unit={t.settings.mm} value={size} limits={lights.size_limits} logarithmic rest={rest}
        change={(to, held) => session.change(`light size ${index}`, (now) => lights.size_light(now, index, to), held)} />
    </>
  );
}

/** Lamps and skies alike: a sky turns with the camera, too. */
function Locked({ session, light, index }: TexturePartProps) {
  return (
    <Switch label={t.settings.light.locked} on={light.cameraLocked} change={(locked) => {
      const pose = session.scene.value && camera_of(session.scene.value);
      if (pose) session.change(`light lock ${index}`, (now) => lights.lock_light(now, index, locked, pose));
      session.rest();
    }} />
  );
}

/** Those that are seen from the same side. */
const others_of = (session: ViewerSession, light: Light): lights.Place[] =>
  (session.scene.value?.lights ?? []).filter((one) => one !== light && one.cameraLocked === light.cameraLocked && !one.disabled).flatMap((one) => lights.place_of(one) ?? []);
