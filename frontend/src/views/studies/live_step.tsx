import { useMemo, useState } from "preact/hooks";
import type { Rgb, Scene } from "../../protocol/gen/api/proto/scene_pb";
import { cameraOf } from "../../protocol/messages";
import { hexOf } from "../../scene/colour";
import { channelsOf } from "../../scene/transfer";
import {
  textIn,
  type Answer,
  type ColoursStep,
  type Material,
  type RatingStep,
  type ViewpointStep,
  type ViewStep,
} from "../../studies/definition";
import type { DelayLine } from "../../studies/delay_line";
import { shownMaterials, withMaterialColour } from "../../studies/materials";
import type { Participation } from "../../studies/participation";
import { studyPlace } from "../../studies/place";
import { cameraValue } from "../../studies/views";
import { language, t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { InPicture } from "../picture/in_picture";
import { useApp } from "../state";
import { ColourControl } from "../viewer/settings/controls";
import { LightWindow } from "../viewer/settings/light_window";
import { RatingForm } from "./answer_forms";
import { LivePicture } from "./live_picture";
import { Paragraphs } from "./study_frame";

export interface LiveStepProps {
  readonly step: RatingStep | ColoursStep | ViewpointStep;
  readonly participation: Participation;
  readonly done: (value: Answer) => void;
}

/** A step with a live picture, of which a participant can change what the researcher allows. */
export function LiveStep({ step, participation, done }: LiveStepProps) {
  const { place, again, session, setSession, onRecording } = useStepPicture(step, participation);
  const turns = step.kind === "viewpoint" || (step.view?.may_change.includes("camera") ?? false);
  return (
    <div class="study-live">
      <StepIntro step={step} />
      <LivePicture
        key={again.count}
        place={place}
        turns={turns}
        onSession={setSession}
        onRecording={onRecording}
        onAgain={again.begin}
      />
      <section class="study-panel">
        {session ? <Changes step={step} session={session} /> : null}
        {session ? <Task step={step} session={session} done={done} /> : null}
        {turns ? <p class="hint">{t.takePart.hint}</p> : null}
      </section>
    </div>
  );
}

/**
 * The picture of a step, whose stream `delay` holds back if it is not null. `again` begins with a new session after an
 * interruption.
 */
export function useStepPicture(step: ViewStep, participation: Participation, delay: DelayLine | null = null) {
  const { api } = useApp();
  const [count, setCount] = useState(0);
  const [session, setSession] = useState<ViewerSession | null>(null);
  const place = useMemo(
    () => studyPlace(api, participation, step, delay),
    // eslint-disable-next-line react-hooks/exhaustive-deps -- another count begins a new session
    [api, participation, step, delay, count],
  );
  const onRecording = participation.record
    ? (recording: object) => participation.queue.record(step.id, recording)
    : undefined;
  return { place, again: { count, begin: () => setCount(count + 1) }, session, setSession, onRecording };
}

/** What a step asks for, and which part of the scan it is about. */
export function StepIntro({ step }: { readonly step: ViewStep }) {
  const name = step.view?.region ? textIn(step.view.region.name, language.value) : null;
  return (
    <section class="study-intro">
      <Paragraphs {...textIn(step.text, language.value)} />
      {name?.text ? (
        <p class="study-part" lang={name.lang}>
          {t.takePart.part(name.text)}
        </p>
      ) : null}
    </section>
  );
}

/** Controls for what a step lets participants change, besides its own task. */
function Changes({ step, session }: { readonly step: ViewStep; readonly session: ViewerSession }) {
  const picture = useMemo(() => new InPicture(), []);
  const may = step.view?.may_change ?? [];
  const scene = session.editor.scene.value;
  return (
    <>
      {may.includes("colours") && step.kind !== "colours" && scene ? (
        <ColourFields
          session={session}
          materials={shownMaterials(scene).map((channel, i) => ({
            channel,
            name: { [language.value]: t.settings.look.channel(channel, i + 1) },
          }))}
        />
      ) : null}
      {may.includes("lights") ? (
        <details class="more">
          <summary>{t.takePart.lights}</summary>
          <LightWindow session={session} leads picture={picture} />
        </details>
      ) : null}
    </>
  );
}

interface TaskProps extends Pick<LiveStepProps, "step" | "done"> {
  readonly session: ViewerSession;
}

function Task({ step, session, done }: TaskProps) {
  if (step.kind === "rating") return <RatingForm step={step} done={done} />;
  if (step.kind === "colours") return <ColoursTask step={step} session={session} done={done} />;
  const send = () => {
    // As presets keep it, so that the shape of the window does not change the distance.
    const now = session.editor.toSave();
    const begun = session.editor.begun.value ?? now;
    const [camera, start] = [now && cameraOf(now), begun && cameraOf(begun)];
    if (camera && start) done({ camera: cameraValue(camera), start: cameraValue(start) });
  };
  return (
    <button type="button" class="button button-main" disabled={session.pictures.picture.value === null} onClick={send}>
      {t.takePart.myView}
    </button>
  );
}

/** Returns the colour of a channel, which may appear more than once. */
const colourOf = (scene: Scene, channel: string): Rgb | undefined =>
  channelsOf(scene).find(({ name }) => name === channel)?.diffuse;

interface ColourFieldsProps {
  readonly session: ViewerSession;
  readonly materials: readonly Material[];
}

function ColourFields({ session: { editor }, materials }: ColourFieldsProps) {
  const scene = editor.scene.value;
  if (!scene) return null;
  return (
    <div class="study-colours">
      {materials.map(({ channel, name }) => (
        <ColourControl
          key={channel}
          label={textIn(name, language.value).text}
          value={colourOf(scene, channel)}
          rest={() => editor.rest()}
          change={(diffuse, held) =>
            editor.change(`colour ${channel}`, (now) => withMaterialColour(now, channel, hexOf(diffuse)), held)
          }
        />
      ))}
    </div>
  );
}

function ColoursTask({ step, session, done }: TaskProps & { readonly step: ColoursStep }) {
  const { editor } = session;
  const begun = editor.begun.value;
  const send = () => {
    const now = editor.scene.value;
    if (!now || !begun) return;
    const colours = step.materials.map(({ channel }) => ({
      channel,
      from: hexOf(colourOf(begun, channel)),
      to: hexOf(colourOf(now, channel)),
    }));
    done({ colours });
  };
  const reset = () =>
    editor.change("first colours", (now) =>
      step.materials.reduce((scene, { channel }) => {
        const first = begun && colourOf(begun, channel);
        return first ? withMaterialColour(scene, channel, hexOf(first)) : scene;
      }, now),
    );
  return (
    <>
      <ColourFields session={session} materials={step.materials} />
      <div class="study-choices">
        <button type="button" class="button" onClick={reset}>
          {t.takePart.resetColours}
        </button>
        <button type="button" class="button button-main" disabled={!begun} onClick={send}>
          {t.takePart.myColours}
        </button>
      </div>
    </>
  );
}
