import { useRef } from "preact/hooks";
import { textIn, type Answer, type Step } from "../../studies/definition";
import type { Participation } from "../../studies/participation";
import { language, t } from "../../texts";
import { ChoiceForm, RatingForm, WordsForm } from "./answer_forms";
import { LatencyTask } from "./latency_task";
import { LiveStep } from "./live_step";
import { OrderTask } from "./order_task";
import { Paragraphs } from "./study_frame";

export interface StepPageProps {
  readonly step: Step;
  readonly participation: Participation;
  readonly answer: (value: Answer, durationMs: number) => void;
}

/** One step of a participant. */
export function StepPage({ step, participation, answer }: StepPageProps) {
  const begunMs = useRef(performance.now());
  const done = (value: Answer) => answer(value, performance.now() - begunMs.current);
  if (step.kind === "latency") return <LatencyTask step={step} participation={participation} done={done} />;
  if (step.kind === "viewpoint" || step.kind === "colours" || (step.kind === "rating" && step.view))
    return <LiveStep step={step} participation={participation} done={done} />;
  return (
    <div class="study-step">
      <Paragraphs {...textIn(step.text, language.value)} />
      <PlainTask step={step} participation={participation} done={done} />
    </div>
  );
}

interface PlainTaskProps {
  readonly step: Step;
  readonly participation: Participation;
  readonly done: (value: Answer) => void;
}

/** The task of a step without a live picture. */
function PlainTask({ step, participation, done }: PlainTaskProps) {
  switch (step.kind) {
    case "rating":
      return <RatingForm step={step} done={done} />;
    case "choice":
      return <ChoiceForm step={step} done={done} />;
    case "words":
      return <WordsForm done={done} />;
    case "order":
      return <OrderTask step={step} participation={participation} done={done} />;
    default:
      return (
        <p>
          <button type="button" class="button button-main" onClick={() => done({})}>
            {t.takePart.next}
          </button>
        </p>
      );
  }
}
