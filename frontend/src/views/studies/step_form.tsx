import { useState } from "preact/hooks";
import type { Study } from "../../api/studies";
import { delaysFrom, limits, type Finding } from "../../studies/check";
import {
  freeId,
  hasView,
  type ChoiceStep,
  type LatencyStep,
  type RatingStep,
  type Step,
  type View,
} from "../../studies/definition";
import { withStepView } from "../../studies/materials";
import { t } from "../../texts";
import { Field } from "../field";
import { IconButton } from "../icon_button";
import { Switch } from "../viewer/settings/controls";
import { MaterialFields } from "./material_fields";
import { OrderPictures } from "./order_pictures";
import { TextFields } from "./text_fields";
import type { ViewChoice } from "./view_settings";
import { ViewField } from "./view_field";

export interface StepFormProps {
  readonly step: Step;
  readonly study: Study | null;
  readonly save: () => Promise<Study>;
  /** The picture of another step, which this one can use too. */
  readonly otherView: View | null;
  readonly findings: readonly Finding[];
  readonly change: (step: Step) => void;
  readonly chooseView: (choice: ViewChoice) => void;
}

/** The fields of one step. */
export function StepForm(props: StepFormProps) {
  const { step, findings, change } = props;
  const text = t.studies;
  return (
    <div class="study-step-form">
      <TextFields
        label={text.text}
        value={step.text}
        most={limits.text}
        long
        change={(words) => change({ ...step, text: words })}
      />
      {hasView(step) ? (
        <ViewField
          step={step}
          other={props.otherView}
          change={change}
          choose={() =>
            props.chooseView({
              view: step.view ?? null,
              kind: step.kind,
              use: (view) => change(withStepView(step, view)),
            })
          }
        />
      ) : null}
      <KindFields {...props} />
      {step.kind === "consent" ? null : (
        <details class="more">
          <summary>{text.group}</summary>
          <Field
            label={text.group}
            value={step.group}
            most={40}
            verbatim
            hint={text.groupHint}
            onInput={(value) => change({ ...step, group: value.toLowerCase().replace(/[^a-z0-9-]/g, "") })}
          />
        </details>
      )}
      {findings.map(({ problem }) => (
        <p class="field-fault" key={problem}>
          {text.problems[problem]}
        </p>
      ))}
    </div>
  );
}

function KindFields({ step, study, save, change, chooseView }: StepFormProps) {
  switch (step.kind) {
    case "rating":
      return <RatingFields step={step} change={change} />;
    case "colours":
      return <MaterialFields step={step} change={change} />;
    case "order":
      return <OrderPictures step={step} study={study} save={save} chooseView={chooseView} />;
    case "choice":
      return <OptionFields step={step} change={change} />;
    case "latency":
      return <DelaysField step={step} change={change} />;
    default:
      return null;
  }
}

interface Changing<Kind extends Step> {
  readonly step: Kind;
  readonly change: (step: Step) => void;
}

const wholeOf = (text: string): number => (text.trim() === "" ? Number.NaN : Number(text));
const shown = (value: number): string => (Number.isNaN(value) ? "" : String(value));

function RatingFields({ step, change }: Changing<RatingStep>) {
  const text = t.studies;
  return (
    <>
      <div class="study-texts">
        <Field
          label={text.low}
          value={shown(step.low)}
          digits
          onInput={(value) => change({ ...step, low: wholeOf(value) })}
        />
        <Field
          label={text.high}
          value={shown(step.high)}
          digits
          onInput={(value) => change({ ...step, high: wholeOf(value) })}
        />
      </div>
      <TextFields
        label={text.lowText}
        value={step.low_text}
        most={limits.title}
        change={(low) => change({ ...step, low_text: low })}
      />
      <TextFields
        label={text.highText}
        value={step.high_text}
        most={limits.title}
        change={(high) => change({ ...step, high_text: high })}
      />
    </>
  );
}

function OptionFields({ step, change }: Changing<ChoiceStep>) {
  const text = t.studies;
  const { options } = step;
  return (
    <div class="study-options" role="group" aria-label={text.options}>
      {options.map((option, i) => (
        <div class="study-option" key={option.id}>
          <TextFields
            label={text.option(i + 1)}
            value={option.text}
            most={limits.title}
            change={(words) =>
              change({ ...step, options: options.map((one) => (one === option ? { ...one, text: words } : one)) })
            }
          />
          <IconButton
            icon="trash"
            label={text.optionRemove(i + 1)}
            disabled={options.length <= 2}
            onClick={() => change({ ...step, options: options.filter((one) => one !== option) })}
          />
        </div>
      ))}
      <p>
        <button
          type="button"
          class="button button-small"
          disabled={options.length >= limits.options}
          onClick={() => {
            const id = freeId(
              options.map((one) => one.id),
              "option",
            );
            change({ ...step, options: [...options, { id, text: {} }] });
          }}
        >
          {text.optionAdd}
        </button>
      </p>
      <Switch label={text.multiple} on={step.multiple} change={(multiple) => change({ ...step, multiple })} />
    </div>
  );
}

function DelaysField({ step, change }: Changing<LatencyStep>) {
  const [typed, setTyped] = useState(step.delays_ms.join(", "));
  const isWrong = delaysFrom(typed) === null;
  return (
    <Field
      label={t.studies.delays}
      value={typed}
      hint={t.studies.delaysHint}
      {...(isWrong ? { fault: t.studies.delaysWrong } : {})}
      onInput={(text) => {
        setTyped(text);
        change({ ...step, delays_ms: delaysFrom(text) ?? [] });
      }}
    />
  );
}
