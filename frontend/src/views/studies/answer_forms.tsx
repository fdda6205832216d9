import type { ComponentChildren } from "preact";
import { useId, useState } from "preact/hooks";
import { limits } from "../../studies/check";
import { textIn, type Answer, type ChoiceStep, type RatingStep } from "../../studies/definition";
import { language, t } from "../../texts";

export type Done = (value: Answer) => void;

interface AnswerFormProps {
  /** The button sends the answer. */
  readonly label?: string;
  /** What is missing, or empty. */
  readonly missing: string;
  readonly submit: () => void;
  readonly children: ComponentChildren;
}

/** A form that says what is missing, in place of a button that does nothing. */
function AnswerForm({ label = t.takePart.next, missing, submit, children }: AnswerFormProps) {
  const [asked, setAsked] = useState(false);
  return (
    <form
      class="study-form"
      onSubmit={(event) => {
        event.preventDefault();
        setAsked(true);
        if (!missing) submit();
      }}
    >
      {children}
      <p class="field-fault" role="alert">
        {asked ? missing : ""}
      </p>
      <button type="submit" class="button button-main">
        {label}
      </button>
    </form>
  );
}

export interface ScaleProps {
  readonly label: string;
  readonly low: number;
  readonly high: number;
  readonly lowText: string;
  readonly highText: string;
  readonly value: number | null;
  /** Called with null while what is typed is not a value of the scale. */
  readonly choose: (value: number | null) => void;
}

/** A scale of whole numbers. Long scales are a list, because buttons for them would fill the page. */
export function Scale({ label, low, high, lowText, highText, value, choose }: ScaleProps) {
  const name = useId();
  const [typed, setTyped] = useState(value === null ? "" : String(value));
  const values = Array.from({ length: high - low + 1 }, (_, i) => low + i);
  const ends = (
    <div class="study-scale-ends">
      <span>{lowText}</span>
      <span>{highText}</span>
    </div>
  );
  if (values.length > 21)
    return (
      <div>
        <label class="field">
          <span>{`${label} (${low.toFixed(0)}–${high.toFixed(0)})`}</span>
          <input
            type="number"
            class="choice"
            min={low}
            max={high}
            value={typed}
            onInput={(event) => {
              const { value: text, valueAsNumber: number } = event.currentTarget;
              setTyped(text);
              choose(Number.isInteger(number) && number >= low && number <= high ? number : null);
            }}
          />
        </label>
        {ends}
      </div>
    );
  return (
    <fieldset class="study-scale">
      <legend class="visually-hidden">{label}</legend>
      <div class="study-scale-values" style={values.length <= 11 ? { "--count": values.length } : undefined}>
        {values.map((one) => (
          <label key={one}>
            <input type="radio" name={name} checked={value === one} onChange={() => choose(one)} />
            <span>{one}</span>
          </label>
        ))}
      </div>
      {ends}
    </fieldset>
  );
}

export function RatingForm({ step, done }: { readonly step: RatingStep; readonly done: Done }) {
  const [rating, setRating] = useState<number | null>(null);
  return (
    <AnswerForm
      missing={rating === null ? t.takePart.chooseRating : ""}
      submit={() => rating !== null && done({ rating })}
    >
      <Scale
        label={textIn(step.text, language.value).text}
        low={step.low}
        high={step.high}
        lowText={textIn(step.low_text, language.value).text}
        highText={textIn(step.high_text, language.value).text}
        value={rating}
        choose={setRating}
      />
    </AnswerForm>
  );
}

export function ChoiceForm({ step, done }: { readonly step: ChoiceStep; readonly done: Done }) {
  const [chosen, setChosen] = useState<readonly string[]>([]);
  const name = useId();
  const toggle = (id: string, on: boolean) =>
    setChosen(
      step.multiple
        ? step.options.map((one) => one.id).filter((one) => (one === id ? on : chosen.includes(one)))
        : [id],
    );
  return (
    <AnswerForm
      missing={!step.multiple && chosen.length === 0 ? t.takePart.chooseOne : ""}
      submit={() => done({ choice: chosen })}
    >
      <fieldset class="reasons">
        <legend class="visually-hidden">{textIn(step.text, language.value).text}</legend>
        {step.multiple ? <p class="muted">{t.takePart.chooseSome}</p> : null}
        {step.options.map((option) => {
          const { text, lang } = textIn(option.text, language.value);
          return (
            <label key={option.id} lang={lang}>
              <input
                type={step.multiple ? "checkbox" : "radio"}
                name={name}
                checked={chosen.includes(option.id)}
                onChange={(event) => toggle(option.id, event.currentTarget.checked)}
              />
              {text}
            </label>
          );
        })}
      </fieldset>
    </AnswerForm>
  );
}

export function WordsForm({ done }: { readonly done: Done }) {
  const [words, setWords] = useState("");
  const id = useId();
  return (
    <AnswerForm missing="" submit={() => done({ words: words.trim() })}>
      <div class="field">
        <label for={id}>{t.takePart.words}</label>
        <textarea
          id={id}
          class="prose"
          rows={5}
          maxLength={limits.words}
          value={words}
          onInput={(event) => setWords(event.currentTarget.value)}
        />
        {words.length > limits.words - 200 ? (
          <p class="field-hint">{t.takePart.left(limits.words - words.length)}</p>
        ) : null}
      </div>
    </AnswerForm>
  );
}
