import { typed_number, type Limits } from "../../../scene/numbers";
import { tools, type Shown, type Slices } from "../../../slices/model";
import { without_last } from "../../../slices/measure";
import { usual_windows, window_limits, type UsualWindow } from "../../../slices/window";
import { Modality, type VolumeHeader } from "../../../protocol/messages";
import { t } from "../../../texts";
import { number_text } from "../../format";
import { Icon } from "../../icons";

const views: readonly Shown[] = ["four", "axial", "sagittal", "coronal", "picture"];

/** What is shown, what a hand does, and the window in numbers. */
export function SliceBar({ slices, volume }: { readonly slices: Slices; readonly volume: VolumeHeader }) {
  const tool = slices.tool.value;
  const window = slices.window.value;
  const usual = (Object.keys(usual_windows) as UsualWindow[]).find((name) => usual_windows[name].centre === window.centre && usual_windows[name].width === window.width);
  return (
    <div class="glass slice-bar">
      <Choice label={t.slices.views} names={views.filter((view) => !(slices.narrow.value && view === "four"))} texts={t.slices.view} chosen={slices.view.value}
        choose={(view) => (slices.shown.value = view)} />
      <Choice label={t.slices.tools} names={tools} texts={t.slices.tool} titles={t.slices.tool_help} chosen={tool} choose={(name) => (slices.tool.value = name)} />
      <div class="slice-window" role="group" aria-label={t.slices.usual}>
        {volume.modality === Modality.CT ? (
          <select aria-label={t.slices.usual} value={usual ?? ""} onChange={(event) => {
            const name = event.currentTarget.value as UsualWindow | "";
            if (name !== "") slices.set_window(usual_windows[name]);
          }}>
            <option value="">{t.slices.usual_own}</option>
            {(Object.keys(usual_windows) as UsualWindow[]).map((name) => <option key={name} value={name}>{t.slices.usual_windows[name]}</option>)}
          </select>
        ) : null}
        <Typed label={t.slices.centre} value={window.centre} limits={window_limits.centre} take={(centre) => slices.set_window({ ...window, centre })} />
        <Typed label={t.slices.width} value={window.width} limits={window_limits.width} take={(width) => slices.set_window({ ...window, width })} />
      </div>
      <button type="button" class="icon-button" aria-label={t.slices.remove_measure} title={t.slices.remove_measure} aria-disabled={slices.measures.value.length === 0}
        onClick={() => (slices.measures.value = without_last(slices.measures.value))}>
        <Icon name="trash" />
      </button>
      <button type="button" class="icon-button" aria-label={t.slices.reset} title={t.slices.reset} onClick={() => slices.reset()}>
        <Icon name="reset" />
      </button>
    </div>
  );
}

interface ChoiceProps<Name extends string> {
  readonly label: string;
  readonly names: readonly Name[];
  readonly texts: Readonly<Record<Name, string>>;
  readonly titles?: Readonly<Record<Name, string>>;
  readonly chosen: Name;
  readonly choose: (name: Name) => void;
}

/** One of a few, side by side: radio buttons of the platform that look like a row of buttons. */
function Choice<Name extends string>({ label, names, texts, titles, chosen, choose }: ChoiceProps<Name>) {
  return (
    <fieldset class="slice-choice">
      <legend class="visually-hidden">{label}</legend>
      {names.map((name) => (
        <label key={name} title={titles?.[name]}>
          <input type="radio" name={label} value={name} checked={name === chosen} onChange={() => choose(name)} />
          <span>{texts[name]}</span>
        </label>
      ))}
    </fieldset>
  );
}

interface TypedProps {
  readonly label: string;
  readonly value: number;
  readonly limits: Limits;
  readonly take: (value: number) => void;
}

/** What is no number within the limits is put back to what it was. */
function Typed({ label, value, limits, take }: TypedProps) {
  return (
    <label class="slice-typed">
      <span>{label}</span>
      <input type="text" inputMode="decimal" autocomplete="off" maxLength={12} value={number_text(value)}
        onFocus={(event) => event.currentTarget.select()}
        onKeyDown={(event) => {
          if (event.key === "Enter") event.currentTarget.blur();
        }}
        onBlur={(event) => {
          const typed = typed_number(event.currentTarget.value, limits);
          event.currentTarget.value = number_text(typed ?? value);
          if (typed !== null && typed !== value) take(typed);
        }} />
    </label>
  );
}
