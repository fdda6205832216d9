import type { Light } from "../../../protocol/gen/api/proto/scene_pb";
import { cameraOf } from "../../../protocol/messages";
import { hueOf } from "../../../scene/colour";
import { showEnvironment } from "../../../scene/lens";
import * as lights from "../../../scene/lights";
import { isSky } from "../../../scene/textures";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Icon } from "../../icons";
import type { Picking } from "../../picture/in_picture";
import {
  ColourControl,
  NameControl,
  NumberControl,
  Switch,
  type PictureWindowProps,
  type WindowProps,
} from "./controls";
import { EnvironmentPart } from "./environment_part";
import { LightBall } from "./light_ball";
import { sceneEdits } from "./scene_edits";
import { TexturePart } from "./texture_part";

interface LightProps {
  readonly session: ViewerSession;
  readonly light: Light;
  readonly index: number;
}

/** One light: its direction, brightness and colour first, the rest behind "More". */
export function OneLight({ session, leads, picture, light, index }: LightProps & PictureWindowProps) {
  const text = t.settings.light;
  const { live, rest } = sceneEdits(session.editor);
  return (
    <>
      <LightDirection session={session} leads={leads} light={light} index={index} />
      <NumberControl
        label={text.brightness}
        value={lights.intensityOf(light)}
        limits={lights.intensityLimits}
        slide={{ low: 0.05, high: 20 }}
        logarithmic
        rest={rest}
        change={live(`light brightness ${index}`, (now, to: number) => lights.dimLight(now, index, to))}
      />
      <ColourControl
        label={text.colour}
        value={hueOf(lights.radianceOf(light))}
        rest={rest}
        change={live(`light colour ${index}`, (now, hue: ReturnType<typeof hueOf>) =>
          lights.colourLight(now, index, hue),
        )}
      />
      {isSky(light) ? <EnvironmentPart session={session} light={light} index={index} /> : null}
      <details class="more">
        <summary>{t.settings.more}</summary>
        <LightPlace session={session} light={light} index={index} />
        <LightAspect session={session} light={light} index={index} />
        <LightTarget session={session} picture={picture} light={light} index={index} />
        <CameraLock session={session} light={light} index={index} />
        {isSky(light) ? <SkyShown session={session} /> : null}
        <TexturePart session={session} light={light} index={index} />
        <LightName session={session} light={light} index={index} />
        <RemoveLight session={session} light={light} index={index} />
      </details>
    </>
  );
}

/** Returns a handler that moves a light. Each light's movements are one undo step. */
const moveLight = (session: ViewerSession, index: number) =>
  sceneEdits(session.editor).live(`light place ${index}`, (now, to: Partial<lights.Place>) =>
    lights.placeLight(now, index, to),
  );

/** The ball on which a light with a direction is moved. */
function LightDirection({ session, leads, light, index }: LightProps & WindowProps) {
  const text = t.settings.light;
  const place = lights.placeOf(light);
  if (!place) return null;
  return (
    <div class="ball-row">
      <LightBall
        direction={place}
        others={othersOf(session, light)}
        leads={leads}
        change={moveLight(session, index)}
        rest={() => session.editor.rest()}
      />
      <p class="hint">
        {light.cameraLocked ? text.ballFrom.camera : text.ballFrom.patient}. {t.settings.picture.light}
      </p>
    </div>
  );
}

/** The position of a light in numbers. */
function LightPlace({ session, light, index }: LightProps) {
  const text = t.settings.light;
  const place = lights.placeOf(light);
  const size = lights.sizeOf(light);
  const { live, rest } = sceneEdits(session.editor);
  const move = moveLight(session, index);
  if (!place || size === null) return null;
  return (
    <>
      <NumberControl
        label={text.right}
        unit={t.settings.degrees}
        value={place.right}
        limits={lights.turnLimits}
        rest={rest}
        change={(right, held) => move({ right }, held)}
      />
      <NumberControl
        label={text.up}
        unit={t.settings.degrees}
        value={place.up}
        limits={lights.tiltLimits}
        rest={rest}
        change={(up, held) => move({ up }, held)}
      />
      <NumberControl
        label={text.distance}
        unit={t.settings.mm}
        value={place.distance}
        limits={lights.distanceLimits}
        logarithmic
        rest={rest}
        change={(distance, held) => move({ distance }, held)}
      />
      <NumberControl
        label={text.size}
        unit={t.settings.mm}
        value={size}
        limits={lights.sizeLimits}
        logarithmic
        rest={rest}
        change={live(`light size ${index}`, (now, to: number) => lights.sizeLight(now, index, to))}
      />
    </>
  );
}

/** The proportions of a rectangle or box. */
function LightAspect({ session, light, index }: LightProps) {
  const text = t.settings.light;
  const aspect = lights.aspectOf(light);
  const { live, rest } = sceneEdits(session.editor);
  const shape = live(`light aspect ${index}`, (now, to: Parameters<typeof lights.shapeLight>[2]) =>
    lights.shapeLight(now, index, to),
  );
  if (!aspect) return null;
  const control = { limits: lights.aspectLimits, logarithmic: true, step: 0.01, rest };
  return (
    <>
      <NumberControl
        {...control}
        label={text.aspect}
        value={aspect.width}
        change={(width, held) => shape({ width }, held)}
      />
      {aspect.depth === null ? null : (
        <NumberControl
          {...control}
          label={text.depth}
          value={aspect.depth}
          change={(depth, held) => shape({ depth }, held)}
        />
      )}
    </>
  );
}

/** Where a one-sided light shines: a point relative to the middle, or one that is chosen in the picture. */
function LightTarget({ session, picture, light, index }: LightProps & Pick<PictureWindowProps, "picture">) {
  const text = t.settings.light;
  const target = lights.targetOf(light);
  const { live, apply, rest } = sceneEdits(session.editor);
  const turn = live(`light target ${index}`, (now, to: Partial<lights.Target>) => lights.turnLight(now, index, to));
  if (!target) return null;
  const control = { unit: t.settings.mm, limits: lights.targetLimits, slide: { low: -300, high: 300 }, rest };
  return (
    <>
      <NumberControl
        {...control}
        label={text.targetRight}
        value={target.right}
        change={(right, held) => turn({ right }, held)}
      />
      <NumberControl {...control} label={text.targetUp} value={target.up} change={(up, held) => turn({ up }, held)} />
      <p class="saved-acts">
        <button
          type="button"
          class="button button-small"
          aria-pressed={picture.picking.value !== null}
          onClick={() => {
            picture.picking.value = picture.picking.value ? null : targetPicking(session, index);
          }}
        >
          <Icon name="aperture" />
          {text.pickTarget}
        </button>
        <button
          type="button"
          class="button button-small"
          disabled={target.right === 0 && target.up === 0}
          onClick={() => apply("light target", (now) => lights.turnLight(now, index, { right: 0, up: 0 }))}
        >
          {text.targetMiddle}
        </button>
      </p>
    </>
  );
}

/** Turns the light to the surface at the chosen point of the picture. */
function targetPicking(session: ViewerSession, index: number): Picking {
  const text = t.settings.light;
  return {
    label: text.pickTargetLabel,
    pick: async ({ x, y }) => {
      const answer = await session.depthAt(x, y);
      if (!answer.answered) return t.settings.lens.pickLost;
      if (!answer.seen) return t.settings.lens.pickNothing;
      const { place } = answer.seen;
      const scene = session.editor.scene.value;
      const pose = scene && cameraOf(scene);
      const turned = scene && pose && lights.turnLightTo(scene, index, pose, place);
      if (!turned) return text.behindLight;
      sceneEdits(session.editor).apply(
        "light target picked",
        (now) => lights.turnLightTo(now, index, pose, place) ?? now,
      );
      return null;
    },
  };
}

/** Whether the light turns with the camera, which also works for the environment. */
function CameraLock({ session, light, index }: LightProps) {
  return (
    <Switch
      label={t.settings.light.locked}
      on={light.cameraLocked}
      change={(locked) => {
        const pose = session.editor.scene.value && cameraOf(session.editor.scene.value);
        if (pose) session.editor.change(`light lock ${index}`, (now) => lights.lockLight(now, index, locked, pose));
        session.editor.rest();
      }}
    />
  );
}

/** Whether the environment light is visible behind the volume. */
function SkyShown({ session }: Pick<LightProps, "session">) {
  return (
    <Switch
      label={t.settings.lens.environment}
      on={session.editor.scene.value?.display?.showEnvironment ?? false}
      change={sceneEdits(session.editor).once("environment", showEnvironment)}
    />
  );
}

function LightName({ session, light, index }: LightProps) {
  return (
    <NameControl
      label={t.settings.light.name}
      value={t.settings.nameOf(light.name)}
      most={60}
      change={sceneEdits(session.editor).once(`light name ${index}`, (now, name: string) =>
        lights.nameLight(now, index, name),
      )}
    />
  );
}

function RemoveLight({ session, light, index }: LightProps) {
  const text = t.settings.light;
  return (
    <p>
      <button
        type="button"
        class="button button-small"
        onClick={() => sceneEdits(session.editor).apply("light removed", (now) => lights.removeLight(now, index))}
      >
        <Icon name="trash" />
        {text.remove(text.light(light.name, index + 1))}
      </button>
    </p>
  );
}

/**
 * Returns the other lights of the same kind, camera-locked or fixed to the patient, which the ball
 * also shows.
 */
const othersOf = (session: ViewerSession, light: Light): lights.Place[] =>
  (session.editor.scene.value?.lights ?? [])
    .filter((one) => one !== light && one.cameraLocked === light.cameraLocked && !one.disabled)
    .flatMap((one) => lights.placeOf(one) ?? []);
