import { useState } from "preact/hooks";
import type { Study } from "../../api/studies";
import { limits, type Finding } from "../../studies/check";
import {
  freeId,
  hasView,
  stepKinds,
  textIn,
  type Definition,
  type Step,
  type StepKind,
  type View,
} from "../../studies/definition";
import { moved } from "../../studies/order";
import { newStep } from "../../studies/templates";
import { language, t } from "../../texts";
import { Choice } from "../choice";
import { IconButton } from "../icon_button";
import { StepForm } from "./step_form";
import type { ViewChoice } from "./view_settings";

export interface StepListProps {
  readonly definition: Definition;
  readonly findings: readonly Finding[];
  readonly study: Study | null;
  readonly save: () => Promise<Study>;
  readonly change: (definition: Definition) => void;
  readonly chooseView: (choice: ViewChoice) => void;
}

/** The steps of a study, in order. One at a time is open for editing. */
export function StepList(props: StepListProps) {
  const { definition, findings, change } = props;
  const [open, setOpen] = useState<string | null>(() => firstToComplete(definition, findings));
  const { steps } = definition;
  const withSteps = (next: readonly Step[]) => change({ ...definition, steps: next });
  const text = t.studies;
  return (
    <section class="share-part">
      <h2>{text.steps}</h2>
      <p class="muted">{text.stepsHint}</p>
      <ol class="study-steps">
        {steps.map((step, i) => (
          <li key={step.id} class="study-step-card" data-kind={step.kind}>
            <StepHead
              step={step}
              number={i + 1}
              last={i === steps.length - 1}
              open={open === step.id}
              setOpen={(on) => setOpen(on ? step.id : null)}
              move={(by) => withSteps(moved(steps, i, i + by))}
              remove={() => withSteps(steps.filter((one) => one !== step))}
            />
            {open === step.id ? (
              <StepForm
                step={step}
                study={props.study}
                save={props.save}
                otherView={otherViewOf(steps, i)}
                findings={findings.filter((one) => one.step === step.id)}
                change={(next) => withSteps(steps.map((one) => (one === step ? next : one)))}
                chooseView={props.chooseView}
              />
            ) : null}
          </li>
        ))}
      </ol>
      <AddStep
        full={steps.length >= limits.steps}
        add={(kind) => {
          const id = freeId(
            steps.map((one) => one.id),
            kind,
          );
          withSteps([...steps, newStep(kind, id)]);
          setOpen(id);
        }}
      />
    </section>
  );
}

/** The first step that lacks a picture or anything else, which is opened at once. */
const firstToComplete = ({ template, steps }: Definition, findings: readonly Finding[]): string | null =>
  steps.find(
    (step) =>
      (template !== "sus" && hasView(step) && !step.view) || findings.some((finding) => finding.step === step.id),
  )?.id ?? null;

/** Returns the picture of the nearest step before, or else of the first one that has one. */
function otherViewOf(steps: readonly Step[], at: number): View | null {
  const views = (of: readonly Step[]) => of.flatMap((step) => (hasView(step) && step.view ? [step.view] : []));
  return views(steps.slice(0, at)).at(-1) ?? views(steps).at(0) ?? null;
}

interface StepHeadProps {
  readonly step: Step;
  readonly number: number;
  readonly last: boolean;
  readonly open: boolean;
  readonly setOpen: (open: boolean) => void;
  readonly move: (by: number) => void;
  readonly remove: () => void;
}

function StepHead({ step, number, last, open, setOpen, move, remove }: StepHeadProps) {
  const text = t.studies;
  const name = text.step(number, text.kinds[step.kind]);
  const first = step.kind === "consent";
  return (
    <div class="study-step-head">
      <h3>{name}</h3>
      {open ? null : <p class="study-step-text">{textIn(step.text, language.value).text}</p>}
      <div class="study-step-tools">
        <button
          type="button"
          class="button button-small"
          aria-expanded={open}
          aria-label={open ? `${text.done}: ${name}` : text.editOf(name)}
          onClick={() => setOpen(!open)}
        >
          {open ? text.done : text.edit}
        </button>
        {first ? null : (
          <>
            <IconButton icon="up" label={text.up(name)} disabled={number <= 2} onClick={() => move(-1)} />
            <IconButton icon="down" label={text.down(name)} disabled={last} onClick={() => move(1)} />
            <IconButton icon="trash" label={text.remove(name)} onClick={remove} />
          </>
        )}
      </div>
    </div>
  );
}

function AddStep({ full, add }: { readonly full: boolean; readonly add: (kind: StepKind) => void }) {
  const [kind, setKind] = useState<StepKind>("text");
  return (
    <div class="share-form">
      <Choice
        label={t.studies.kindToAdd}
        value={kind}
        options={stepKinds.map((one) => [one, t.studies.kinds[one]] as const)}
        onChoose={(chosen) => setKind(stepKinds.find((one) => one === chosen) ?? "text")}
      />
      <button type="button" class="button" disabled={full} onClick={() => add(kind)}>
        {t.studies.add}
      </button>
    </div>
  );
}
