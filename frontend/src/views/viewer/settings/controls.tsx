import { useEffect, useId, useRef, useState } from "preact/hooks";
import type { Rgb } from "../../../protocol/gen/api/proto/scene_pb";
import { hexOf, rgbOf } from "../../../scene/colour";
import { typedNumber, type Limits } from "../../../scene/numbers";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { numberText } from "../../format";
import type { HandleSet, InPicture } from "../../picture/in_picture";
import { fromSlider, sliderSteps, toSlider } from "./scale";

export interface WindowProps {
  readonly session: ViewerSession;
  readonly leads: boolean;
}

/** The properties of a window that also has handles in the picture. */
export interface PictureWindowProps extends WindowProps {
  readonly picture: InPicture;
}

/** Called with a new value. `held` means that the pointer is still down. */
export type Changed<Value> = (value: Value, held: boolean) => void;

export interface NumberControlProps {
  readonly label: string;
  readonly unit?: string;
  readonly value: number;
  readonly limits: Limits;
  /** The slider's limits, if they are narrower than those of the number. */
  readonly slide?: Limits;
  readonly logarithmic?: boolean;
  readonly step?: number;
  readonly change: Changed<number>;
  readonly rest: () => void;
}

/** A slider with an input for the number, its unit and its limits. */
export function NumberControl({
  label,
  unit = "",
  value,
  limits,
  slide = limits,
  logarithmic = false,
  step = 1,
  change,
  rest,
}: NumberControlProps) {
  const valueText = `${numberText(value)}${unit ? ` ${unit}` : ""}`;
  return (
    <div class="control" role="group" aria-label={label}>
      <span class="control-name" aria-hidden="true">
        {label}
      </span>
      <Slider
        label={label}
        valueText={valueText}
        at={toSlider(value, slide, logarithmic)}
        change={(at) => change(fromSlider(at, slide, logarithmic, step), true)}
        rest={rest}
      />
      <Typed
        label={label}
        unit={unit}
        value={value}
        limits={limits}
        commit={(typed) => {
          change(typed, false);
          rest();
        }}
      />
    </div>
  );
}

interface SliderProps {
  readonly label: string;
  readonly valueText: string;
  readonly at: number;
  readonly change: (at: number) => void;
  readonly rest: () => void;
}

/** A slider, for which one drag, or one held key, is one undo step. */
function Slider({ label, valueText, at, change, rest }: SliderProps) {
  const keyDown = useRef(false);
  return (
    <input
      type="range"
      min={0}
      max={sliderSteps}
      step={1}
      value={at}
      aria-label={label}
      aria-valuetext={valueText}
      onKeyDown={() => (keyDown.current = true)}
      onKeyUp={() => {
        keyDown.current = false;
        rest();
      }}
      onInput={(event) => change(event.currentTarget.valueAsNumber)}
      onChange={() => {
        if (!keyDown.current) rest();
      }}
      onBlur={() => {
        if (keyDown.current) rest();
        keyDown.current = false;
      }}
    />
  );
}

interface TypedProps {
  readonly label: string;
  readonly unit: string;
  readonly value: number;
  readonly limits: Limits;
  readonly commit: (value: number) => void;
}

/**
 * The input for a number. It is a text field, so that invalid input can be explained. The value is
 * applied with Enter or when the field loses the focus.
 */
function Typed({ label, unit, value, limits, commit }: TypedProps) {
  const id = useId();
  const [text, setText] = useState<string | null>(null);
  const [wrong, setWrong] = useState(false);
  const shown = numberText(value);
  useEffect(() => {
    setText(null);
    setWrong(false);
  }, [shown]);
  const take = () => {
    if (text === null || text === shown) return;
    const typed = typedNumber(text, limits);
    setWrong(typed === null);
    if (typed === null) return;
    setText(null);
    if (typed !== value) commit(typed);
  };
  return (
    <>
      <label class="typed">
        <span class="visually-hidden">{t.settings.typed(label)}</span>
        <input
          type="text"
          inputMode="decimal"
          autocomplete="off"
          maxLength={24}
          value={text ?? shown}
          aria-invalid={wrong || undefined}
          {...(wrong ? { "aria-describedby": `${id}-wrong` } : {})}
          onInput={(event) => setText(event.currentTarget.value)}
          onBlur={take}
          onFocus={(event) => event.currentTarget.select()}
          onKeyDown={(event) => {
            if (event.key === "Enter") take();
            if (event.key !== "Escape" || text === null) return;
            event.preventDefault(); // keeps the window open
            setText(null);
            setWrong(false);
          }}
        />
        <span class="unit">{unit}</span>
      </label>
      {wrong ? (
        <p class="field-fault" id={`${id}-wrong`} role="alert">
          {t.settings.fromTo(numberText(limits.low), numberText(limits.high), unit)}
        </p>
      ) : null}
    </>
  );
}

export interface ColourControlProps {
  readonly label: string;
  readonly value: Rgb | undefined;
  readonly change: Changed<Rgb>;
  readonly rest: () => void;
}

/** The browser's own colour picker. */
export function ColourControl({ label, value, change, rest }: ColourControlProps) {
  return (
    <label class="control control-colour">
      <span class="control-name">{label}</span>
      <input
        type="color"
        value={hexOf(value)}
        onInput={(event) => change(rgbOf(event.currentTarget.value), true)}
        onChange={rest}
      />
    </label>
  );
}

export interface SelectControlProps<Value extends string> {
  readonly label: string;
  readonly value: Value;
  readonly options: readonly (readonly [value: Value, text: string])[];
  readonly change: (value: Value) => void;
  /** Whether the words need the full width. */
  readonly long?: boolean;
}

/** A choice of one value from the browser's own list. */
export function SelectControl<Value extends string>({
  label,
  value,
  options,
  change,
  long = false,
}: SelectControlProps<Value>) {
  return (
    <label class={long ? "control control-long" : "control"}>
      <span class="control-name">{label}</span>
      <select
        class="choice"
        value={value}
        onChange={(event) => {
          const chosen = options.find(([one]) => one === event.currentTarget.value);
          if (chosen) change(chosen[0]);
        }}
      >
        {options.map(([one, text]) => (
          <option key={one} value={one}>
            {text}
          </option>
        ))}
      </select>
    </label>
  );
}

export interface NameControlProps {
  readonly label: string;
  readonly value: string;
  /** Maximum number of characters. */
  readonly most: number;
  readonly change: (name: string) => void;
}

/** The name of a light or a material. */
export function NameControl({ label, value, most, change }: NameControlProps) {
  return (
    <label class="control">
      <span class="control-name">{label}</span>
      <input
        type="text"
        class="name"
        maxLength={most}
        value={value}
        onChange={(event) => change(event.currentTarget.value.trim())}
      />
    </label>
  );
}

export interface SwitchProps {
  readonly label: string;
  readonly on: boolean;
  readonly disabled?: boolean;
  readonly change: (on: boolean) => void;
}

export function Switch({ label, on, disabled = false, change }: SwitchProps) {
  return (
    <label class="control control-switch">
      <input
        type="checkbox"
        checked={on}
        disabled={disabled}
        onChange={(event) => change(event.currentTarget.checked)}
      />
      <span>{label}</span>
    </label>
  );
}

/** Whether the handles stay in the picture when their window is closed. */
export function KeepHandles({ picture, which }: { readonly picture: InPicture; readonly which: HandleSet }) {
  return (
    <Switch
      label={t.settings.picture.keep}
      on={picture.kept.value.includes(which)}
      change={(on) => picture.keep(which, on)}
    />
  );
}
