import { useEffect, useId, useRef, useState } from "preact/hooks";
import type { Rgb } from "../../../protocol/gen/api/proto/scene_pb";
import { hex_of, rgb_of } from "../../../scene/colour";
import { typed_number, type Limits } from "../../../scene/numbers";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { number_text } from "../../format";
import type { HandleSet, InPicture } from "../../picture/in_picture";
import { from_slider, slider_steps, to_slider } from "./scale";

export interface WindowProps {
  readonly session: ViewerSession;
  readonly leads: boolean;
}

/** Of a window whose things lie in the picture, too. */
export interface PictureWindowProps extends WindowProps {
  readonly picture: InPicture;
}

/** `held`: a hand is still on it. */
export type Changed<Value> = (value: Value, held: boolean) => void;

export interface NumberControlProps {
  readonly label: string;
  readonly unit?: string;
  readonly value: number;
  readonly limits: Limits;
  /** Of the slider where it reaches less far than what may be typed. */
  readonly slide?: Limits;
  readonly logarithmic?: boolean;
  readonly step?: number;
  readonly change: Changed<number>;
  readonly rest: () => void;
}

/** A slider, and beside it the number itself: typed, with its unit and its limits said. */
export function NumberControl({ label, unit = "", value, limits, slide = limits, logarithmic = false, step = 1, change, rest }: NumberControlProps) {
  const said = `${number_text(value)}${unit ? ` ${unit}` : ""}`;
  return (
    <div class="control" role="group" aria-label={label}>
      <span class="control-name" aria-hidden="true">{label}</span>
      <Slider label={label} said={said} at={to_slider(value, slide, logarithmic)}
        change={(at) => change(from_slider(at, slide, logarithmic, step), true)} rest={rest} />
      <Typed label={label} unit={unit} value={value} limits={limits} commit={(typed) => {
        change(typed, false);
        rest();
      }} />
    </div>
  );
}

interface SliderProps {
  readonly label: string;
  readonly said: string;
  readonly at: number;
  readonly change: (at: number) => void;
  readonly rest: () => void;
}

/** One way of a hand, or of a key that is held, is one step for undoing. */
function Slider({ label, said, at, change, rest }: SliderProps) {
  const key_down = useRef(false);
  return (
    <input type="range" min={0} max={slider_steps} step={1} value={at} aria-label={label} aria-valuetext={said}
      onKeyDown={() => (key_down.current = true)}
      onKeyUp={() => {
        key_down.current = false;
        rest();
      }}
      onInput={(event) => change(event.currentTarget.valueAsNumber)}
      onChange={() => {
        if (!key_down.current) rest();
      }}
      onBlur={() => {
        if (key_down.current) rest();
        key_down.current = false;
      }} />
  );
}

interface TypedProps {
  readonly label: string;
  readonly unit: string;
  readonly value: number;
  readonly limits: Limits;
  readonly commit: (value: number) => void;
}

/** Text, so that what is no number can be answered in words; taken with Enter or on leaving. */
function Typed({ label, unit, value, limits, commit }: TypedProps) {
  const id = useId();
  const [text, set_text] = useState<string | null>(null);
  const [wrong, set_wrong] = useState(false);
  const shown = number_text(value);
  useEffect(() => {
    set_text(null);
    set_wrong(false);
  }, [shown]);
  const take = () => {
    if (text === null || text === shown) return;
    const typed = typed_number(text, limits);
    set_wrong(typed === null);
    if (typed === null) return;
    set_text(null);
    if (typed !== value) commit(typed);
  };
  return (
    <>
      <label class="typed">
        <span class="visually-hidden">{t.settings.typed(label)}</span>
        <input type="text" inputMode="decimal" autocomplete="off" maxLength={24} value={text ?? shown} aria-invalid={wrong || undefined}
          {...(wrong ? { "aria-describedby": `${id}-wrong` } : {})}
          onInput={(event) => set_text(event.currentTarget.value)}
          onBlur={take}
          onFocus={(event) => event.currentTarget.select()}
          onKeyDown={(event) => {
            if (event.key === "Enter") take();
            if (event.key !== "Escape" || text === null) return;
            event.preventDefault(); // the window stays open
            set_text(null);
            set_wrong(false);
          }} />
        <span class="unit">{unit}</span>
      </label>
      {wrong ? <p class="field-fault" id={`${id}-wrong`} role="alert">{t.settings.from_to(number_text(limits.low), number_text(limits.high), unit)}</p> : null}
    </>
  );
}

export interface ColourControlProps {
  readonly label: string;
  readonly value: Rgb | undefined;
  readonly change: Changed<Rgb>;
  readonly rest: () => void;
}

/** As the device lets one choose a colour. */
export function ColourControl({ label, value, change, rest }: ColourControlProps) {
  return (
    <label class="control control-colour">
      <span class="control-name">{label}</span>
      <input type="color" value={hex_of(value)} onInput={(event) => change(rgb_of(event.currentTarget.value), true)} onChange={rest} />
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
      <input type="checkbox" checked={on} disabled={disabled} onChange={(event) => change(event.currentTarget.checked)} />
      <span>{label}</span>
    </label>
  );
}

/** Whether what is taken hold of in the picture stays there when its window is closed. */
export function KeepHandles({ picture, which }: { readonly picture: InPicture; readonly which: HandleSet }) {
  return <Switch label={t.settings.picture.keep} on={picture.kept.value.includes(which)} change={(on) => picture.keep(which, on)} />;
}
