import { useEffect, useRef, useState } from "preact/hooks";
import { after } from "../../live/paced";
import { cameraOf, sceneFromJson } from "../../protocol/messages";
import { tab } from "../../storage";
import type { Answer, LatencyStep, Trial } from "../../studies/definition";
import { DelayLine } from "../../studies/delay_line";
import { trialsKey, type Participation } from "../../studies/participation";
import { fromRandomView } from "../../studies/place";
import { randomNumbers, shuffled } from "../../studies/random";
import { facingError, vectorOf } from "../../studies/views";
import { t } from "../../texts";
import { Scale } from "./answer_forms";
import { LivePicture } from "./live_picture";
import { StepIntro, useStepPicture } from "./live_step";

export interface LatencyTaskProps {
  readonly step: LatencyStep;
  readonly participation: Participation;
  readonly done: (value: Answer) => void;
}

/** The server refuses a longer time. */
const longestTrialMs = 3_600_000;

type Measured = Pick<Trial, "time_ms" | "error_degrees">;

/** Trials with different delays: turn the marked part to the viewer, then rate the delay. */
export function LatencyTask({ step, participation, done }: LatencyTaskProps) {
  const task = useTrials(step, participation, done);
  const { number, delays, phase } = task;
  return (
    <div class="study-live">
      <StepIntro step={step} />
      <LivePicture
        key={task.again.count}
        place={task.place}
        turns={phase === "turning"}
        resets={false}
        covered={phase !== "turning"}
        onSession={task.setSession}
        onRecording={task.onRecording}
        onAgain={task.again.begin}
      />
      <section class="study-panel">
        <p role="status">{t.takePart.trial(number + 1, delays.length)}</p>
        {phase === "rating" ? (
          <DelayQuestions key={number} answer={task.rate} />
        ) : phase === "turning" ? (
          <button type="button" class="button button-main" onClick={task.measure}>
            {t.takePart.facing}
          </button>
        ) : (
          <button type="button" class="button button-main" disabled={!task.ready} onClick={task.begin}>
            {t.takePart.begin}
          </button>
        )}
        {phase === "rating" ? null : <p class="hint">{t.takePart.hint}</p>}
      </section>
    </div>
  );
}

/** Between "Start" and the first picture of the trial, the phase is `coming`. */
type Phase = "waiting" | "coming" | "turning" | "rating";

/** The state of the trials. Those that are done survive a reload. */
function useTrials(step: LatencyStep, participation: Participation, done: (value: Answer) => void) {
  const { seed } = participation.joined;
  const kept = trialsKey(participation.key, step.id);
  const [delays] = useState(() => shuffled(step.delays_ms, randomNumbers(seed, `delays/${step.id}`)));
  const [trials, setTrials] = useState<readonly Trial[]>(() => keptTrials(tab.getItem(kept)));
  const [phase, setPhase] = useState<Phase>("waiting");
  const [measured, setMeasured] = useState<Measured | null>(null);
  const [delay] = useState(() => new DelayLine({ nowMs: () => performance.now(), after }));
  const picture = useStepPicture(step, participation, delay);
  const { session } = picture;
  const number = trials.length;
  const firstInput = useRef(0);
  const begunMs = useRef(0);
  const shownInput = session?.pictures.picture.value?.inputSeq ?? -1;
  useEffect(() => {
    if (phase !== "coming" || shownInput < firstInput.current) return;
    begunMs.current = performance.now();
    setPhase("turning");
  }, [phase, shownInput]);
  const begin = () => {
    const scene = step.view && sceneFromJson(JSON.stringify(step.view.scene));
    if (!session || !scene) return;
    delay.delayMs = delays[number] ?? 0;
    firstInput.current = session.newestInput + 1;
    session.editor.change(`trial ${number}`, () =>
      session.editor.framed(fromRandomView(scene, seed, `${step.id}/${number}`)),
    );
    session.editor.rest();
    setPhase("coming");
  };
  const measure = () => {
    const pose = session?.editor.scene.value && cameraOf(session.editor.scene.value);
    const region = step.view?.region;
    if (!pose || !region) return;
    const missed = facingError(pose, vectorOf(region.centre));
    setMeasured({
      time_ms: Math.min(Math.round(performance.now() - begunMs.current), longestTrialMs),
      error_degrees: missed,
    });
    setPhase("rating");
  };
  const rate = (acceptable: boolean, rating: number) => {
    if (!measured) return;
    const all = [...trials, { delay_ms: delays[number] ?? 0, ...measured, acceptable, rating }];
    setTrials(all);
    setPhase("waiting");
    tab.setItem(kept, JSON.stringify(all));
    if (all.length < delays.length) return;
    tab.removeItem(kept);
    done({ trials: all });
  };
  const ready = session?.pictures.picture.value != null;
  return { ...picture, delays, number: Math.min(number, delays.length - 1), phase, begin, measure, rate, ready };
}

function keptTrials(text: string | null): readonly Trial[] {
  try {
    const value: unknown = JSON.parse(text ?? "[]");
    return Array.isArray(value) ? (value as Trial[]) : [];
  } catch {
    return [];
  }
}

/** The questions after a trial. */
function DelayQuestions({ answer }: { readonly answer: (acceptable: boolean, rating: number) => void }) {
  const [acceptable, setAcceptable] = useState<boolean | null>(null);
  const [rating, setRating] = useState<number | null>(null);
  const text = t.takePart;
  return (
    <form
      class="study-form"
      onSubmit={(event) => {
        event.preventDefault();
        if (acceptable !== null && rating !== null) answer(acceptable, rating);
      }}
    >
      <fieldset class="reasons">
        <legend>{text.acceptable}</legend>
        {[true, false].map((value) => (
          <label key={String(value)}>
            <input
              type="radio"
              name="acceptable"
              checked={acceptable === value}
              onChange={() => setAcceptable(value)}
            />
            {value ? text.yes : text.no}
          </label>
        ))}
      </fieldset>
      <p>{text.delayRating}</p>
      <Scale label={text.delayRating} low={0} high={10} lowText="" highText="" value={rating} choose={setRating} />
      <button type="submit" class="button button-main" disabled={acceptable === null || rating === null}>
        {text.next}
      </button>
    </form>
  );
}
