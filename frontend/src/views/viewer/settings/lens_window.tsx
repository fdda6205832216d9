import { useState } from "preact/hooks";
import { Shading_Mode as ShadingMode, type Scene } from "../../../protocol/gen/api/proto/scene_pb";
import { showsSlices, slicesOf } from "../../../scene/cuts";
import * as lens from "../../../scene/lens";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Icon } from "../../icons";
import type { InPicture, Picking } from "../../picture/in_picture";
import { ColourControl, NumberControl, SelectControl, Switch, type PictureWindowProps } from "./controls";
import { EffortPart } from "./effort_part";
import { sceneEdits, type SceneEdits } from "./scene_edits";

const shadingModes = [
  ["phase", ShadingMode.PHASE],
  ["surface", ShadingMode.SURFACE],
  ["hybrid", ShadingMode.HYBRID],
] as const;
type ShadingName = (typeof shadingModes)[number][0];

interface LensPartProps {
  readonly scene: Scene;
  readonly edits: SceneEdits;
}

/** Exposure and focus; the projection, the shading and the effort are behind "More". */
export function LensWindow({ session, picture }: PictureWindowProps) {
  const text = t.settings.lens;
  const scene = session.editor.scene.value;
  if (!scene?.camera) return null;
  const edits = sceneEdits(session.editor);
  return (
    <>
      <ExposureControls scene={scene} edits={edits} session={session} />
      <FocusControls scene={scene} edits={edits} session={session} picture={picture} />
      <details class="more">
        <summary>{t.settings.more}</summary>
        <ProjectionControls scene={scene} edits={edits} />
        <ShadingControls scene={scene} edits={edits} />
        <Switch
          label={text.environment}
          on={scene.display?.showEnvironment ?? false}
          change={edits.once("environment", lens.showEnvironment)}
        />
        <EffortPart session={session} />
      </details>
    </>
  );
}

function ExposureControls({ scene, edits, session }: LensPartProps & { readonly session: ViewerSession }) {
  const text = t.settings.lens;
  return (
    <>
      <NumberControl
        label={text.exposure}
        unit={text.stops}
        value={scene.display?.exposure ?? 0}
        limits={lens.exposureLimits}
        slide={{ low: -4, high: 4 }}
        step={0.1}
        rest={edits.rest}
        change={edits.live("exposure", lens.setExposure)}
      />
      <Switch
        label={text.automatic}
        on={lens.isExposureAutomatic(scene)}
        change={edits.once("automatic exposure", lens.setExposureAutomatic)}
      />
      <AutomaticExposureHint scene={scene} stops={session.pictures.picture.value?.stops ?? 0} />
      <Switch label={text.filmic} on={lens.isFilmic(scene)} change={edits.once("curve", lens.setFilmic)} />
      <ColourControl
        label={text.background}
        value={scene.display?.background}
        rest={edits.rest}
        change={edits.live("background", lens.setBackground)}
      />
    </>
  );
}

/** Says by how much the exposure is corrected, so that it can be set by hand instead. */
function AutomaticExposureHint({ scene, stops }: { readonly scene: Scene; readonly stops: number }) {
  const text = t.settings.lens;
  if (!lens.isExposureAutomatic(scene)) return null;
  if (showsSlices(slicesOf(scene))) return <p class="hint">{text.automaticWithSlices}</p>;
  const tenths = Math.round(10 * stops);
  return tenths === 0 ? null : <p class="hint">{text.automaticNow(tenths / 10)}</p>;
}

interface FocusControlsProps extends LensPartProps {
  readonly session: ViewerSession;
  readonly picture: InPicture;
}

function FocusControls({ scene, edits, session, picture }: FocusControlsProps) {
  const text = t.settings.lens;
  const focus = lens.focusOf(scene);
  const setFocus = edits.once("focus", lens.setFocus);
  return (
    <>
      <NumberControl
        label={text.aperture}
        unit={t.settings.mm}
        value={scene.camera?.apertureRadius ?? 0}
        limits={lens.apertureLimits}
        slide={{ low: 0, high: 40 }}
        step={0.2}
        rest={edits.rest}
        change={edits.live("aperture", lens.setAperture)}
      />
      <FocusPicker session={session} picture={picture} />
      <Switch
        label={text.focusMiddle}
        on={focus.middle}
        change={(middle) => setFocus(middle ? null : Math.round(focus.distance))}
      />
      {focus.middle ? null : (
        <NumberControl
          label={text.focus}
          unit={t.settings.mm}
          value={focus.distance}
          limits={lens.focusLimits}
          slide={{ low: 10, high: 3000 }}
          logarithmic
          rest={edits.rest}
          change={edits.live("focus", lens.setFocus)}
        />
      )}
    </>
  );
}

/** The button that starts and ends choosing the focus in the picture. */
function FocusPicker({ session, picture }: Pick<FocusControlsProps, "session" | "picture">) {
  return (
    <p>
      <button
        type="button"
        class="button button-small"
        aria-pressed={picture.picking.value !== null}
        onClick={() => {
          picture.picking.value = picture.picking.value ? null : focusPicking(session);
        }}
      >
        <Icon name="aperture" />
        {t.settings.lens.pick}
      </button>
    </p>
  );
}

function ProjectionControls({ scene, edits }: LensPartProps) {
  const text = t.settings.lens;
  const parallel = lens.isOrthographic(scene);
  const setParallel = edits.once("projection", lens.setOrthographic);
  return (
    <>
      <SelectControl
        label={text.projection}
        value={parallel ? "parallel" : "perspective"}
        options={[
          ["perspective", text.perspective],
          ["parallel", text.orthographic],
        ]}
        change={(chosen) => setParallel(chosen === "parallel")}
      />
      {parallel ? null : (
        <NumberControl
          label={text.fov}
          unit={t.settings.degrees}
          value={scene.camera?.verticalFovDegrees ?? 0}
          limits={lens.fovLimits}
          rest={edits.rest}
          change={edits.live("fov", lens.setFov)}
        />
      )}
    </>
  );
}

function ShadingControls({ scene, edits }: LensPartProps) {
  const text = t.settings.lens;
  const mode = lens.modeOf(scene);
  const chosenName: ShadingName = shadingModes.find(([, one]) => one === mode)?.[0] ?? "phase";
  const setMode = edits.once("shading", lens.setMode);
  return (
    <>
      <NumberControl
        label={text.bounces}
        value={lens.bouncesOf(scene)}
        limits={lens.bouncesLimits}
        slide={{ low: 1, high: 64 }}
        logarithmic
        rest={edits.rest}
        change={edits.live("bounces", lens.setBounces)}
      />
      <p class="hint">{text.bouncesHint}</p>
      <SelectControl
        label={text.shading}
        value={chosenName}
        options={shadingModes.map(([name]) => [name, text.shadings[name]])}
        change={(chosen) => {
          const found = shadingModes.find(([name]) => name === chosen);
          if (found) setMode(found[1]);
        }}
      />
      {mode === ShadingMode.HYBRID ? <GradientScale scene={scene} edits={edits} /> : null}
      {mode === ShadingMode.SURFACE ? null : <PhaseFunction scene={scene} edits={edits} />}
    </>
  );
}

/** The phase function, which a scene describes by g alone: at 0, Henyey-Greenstein is isotropic. */
function PhaseFunction({ scene, edits }: LensPartProps) {
  const text = t.settings.lens;
  const g = scene.phase?.g ?? 0;
  // Keeps the slider while g is moved through 0.
  const [chosen, setChosen] = useState(false);
  const henyey = chosen || g !== 0;
  const setForward = edits.once("phase function", lens.setForward);
  return (
    <>
      <SelectControl
        long
        label={text.phase}
        value={henyey ? "henyey" : "isotropic"}
        options={[
          ["isotropic", text.phases.isotropic],
          ["henyey", text.phases.henyey],
        ]}
        change={(name) => {
          setChosen(name === "henyey");
          setForward(name === "henyey" ? lens.firstForward : 0);
        }}
      />
      {henyey ? (
        <NumberControl
          label={text.forward}
          value={g}
          limits={lens.forwardLimits}
          step={0.01}
          rest={edits.rest}
          change={edits.live("forward", lens.setForward)}
        />
      ) : null}
    </>
  );
}

function GradientScale({ scene, edits }: LensPartProps) {
  return (
    <NumberControl
      label={t.settings.lens.gradient}
      unit={t.settings.look.perMm}
      value={lens.gradientOf(scene)}
      limits={lens.gradientLimits}
      logarithmic
      rest={edits.rest}
      change={edits.live("gradient", lens.setGradient)}
    />
  );
}

/** Focuses on the surface at the chosen point of the picture. */
function focusPicking(session: ViewerSession): Picking {
  const text = t.settings.lens;
  return {
    label: text.pickLabel,
    pick: async ({ x, y }) => {
      const answer = await session.depthAt(x, y);
      if (!answer.answered) return text.pickLost;
      if (!answer.seen) return text.pickNothing;
      const { distance } = answer.seen;
      session.editor.change("focus picked", (before) => lens.focusAt(before, distance));
      session.editor.rest();
      return null;
    },
  };
}
