import type { Signal } from "@preact/signals";
import type { RefObject } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import type { Shown, Slices } from "../../../slices/model";
import { tools } from "../../../slices/tools";
import { usualWindows, windowLimits, type UsualWindow } from "../../../slices/window";
import { Modality, type VolumeHeader } from "../../../protocol/messages";
import { t } from "../../../texts";
import { IconButton } from "../../icon_button";
import { Icon } from "../../icons";
import { CurveControls } from "./curve_controls";
import { ObliqueControls } from "./oblique_controls";
import { Typed } from "./typed";

const views: readonly Shown[] = ["four", "axial", "sagittal", "coronal", "picture"];

interface SliceBarProps {
  readonly slices: Slices;
  readonly volume: VolumeHeader;
}

/** The toolbar of the slices: the layout, the tool, and the grey window in numbers. */
export function SliceBar({ slices, volume }: SliceBarProps) {
  const none = slices.measures.value.length === 0;
  const bar = useRef<HTMLDivElement>(null);
  const following = slices.following.value;
  const shown = !following || (slices.narrow.value && slices.choosable.value);
  useRoomBelow(bar, shown);
  if (following)
    return shown ? (
      <div class="glass slice-bar" ref={bar}>
        <ViewChoice slices={slices} />
      </div>
    ) : null;
  return (
    <div class="glass slice-bar" ref={bar}>
      <ViewChoice slices={slices} />
      <Choice
        label={t.slices.tools}
        names={tools.filter((tool) => tool !== "curve" || slices.access.value !== "shown")}
        texts={t.slices.tool}
        titles={t.slices.toolHelp}
        chosen={slices.tool.value}
        choose={(name) => (slices.tool.value = name)}
      />
      <WindowControls slices={slices} volume={volume} />
      <ObliqueControls slices={slices} />
      <CurveControls slices={slices} />
      <div class="slice-ends">
        <DisplayControls slices={slices} />
        <button
          type="button"
          class="icon-button"
          aria-label={t.slices.removeMeasure}
          title={t.slices.removeMeasure}
          aria-disabled={none}
          onClick={() => slices.removeLastMeasure()}
        >
          <Icon name="trash" />
        </button>
        <IconButton icon="reset" label={t.slices.reset} onClick={() => slices.reset()} />
      </div>
    </div>
  );
}

/** Lets the slices begin below the bar, whose number of lines depends on its words. */
function useRoomBelow(bar: RefObject<HTMLElement | null>, shown: boolean): void {
  useLayoutEffect(() => {
    const element = bar.current;
    const viewer = element?.closest<HTMLElement>(".viewer");
    if (!element || !viewer) return;
    const measure = () => viewer.style.setProperty("--slice-bar", `calc(${element.offsetHeight}px + 0.5rem)`);
    measure();
    const watch = new ResizeObserver(measure);
    watch.observe(element);
    return () => {
      watch.disconnect();
      viewer.style.removeProperty("--slice-bar");
    };
  }, [bar, shown]);
}

function ViewChoice({ slices }: Pick<SliceBarProps, "slices">) {
  return (
    <Choice
      label={t.slices.views}
      names={views.filter((view) => !(slices.narrow.value && view === "four"))}
      texts={t.slices.view}
      chosen={slices.view.value}
      choose={(view) => (slices.shown.value = view)}
    />
  );
}

/** Whether slices are smooth, and whether the colours of the look and of the labels cover the grey. */
function DisplayControls({ slices }: Pick<SliceBarProps, "slices">) {
  const text = t.slices;
  const { overlay, labels } = slices;
  const change =
    <Setting,>(of: Signal<Setting>) =>
    (part: Partial<Setting>) =>
      (of.value = { ...of.value, ...part });
  const [setOverlay, setLabels] = [change(overlay), change(labels)];
  return (
    <div class="slice-choice slice-display" role="group" aria-label={text.display}>
      <Toggle
        text={text.smooth}
        help={text.smoothHelp}
        on={slices.smooth.value}
        change={(on) => (slices.smooth.value = on)}
      />
      <Toggle
        text={text.overlay}
        help={text.overlayHelp}
        on={overlay.value.shown}
        change={(shown) => setOverlay({ shown })}
      />
      {overlay.value.shown ? (
        <Strength label={text.overlayStrength} of={overlay.value} change={(strength) => setOverlay({ strength })} />
      ) : null}
      {slices.hasLabels.value ? (
        <Toggle
          text={text.labels}
          help={text.labelsHelp}
          on={slices.labelsShown.value}
          change={(shown) => setLabels({ shown })}
        />
      ) : null}
      {slices.labelsShown.value ? (
        <Strength label={text.labelsStrength} of={labels.value} change={(strength) => setLabels({ strength })} />
      ) : null}
    </div>
  );
}

interface StrengthProps {
  readonly label: string;
  readonly of: { readonly strength: number };
  readonly change: (strength: number) => void;
}

function Strength({ label, of, change }: StrengthProps) {
  const percent = Math.round(100 * of.strength);
  return (
    <input
      type="range"
      min={0}
      max={100}
      step={5}
      value={percent}
      aria-label={label}
      title={label}
      aria-valuetext={`${percent}${t.settings.percent}`}
      onInput={(event) => change(event.currentTarget.valueAsNumber / 100)}
    />
  );
}

interface ToggleProps {
  readonly text: string;
  readonly help: string;
  readonly on: boolean;
  readonly change: (on: boolean) => void;
}

function Toggle({ text, help, on, change }: ToggleProps) {
  return (
    <label title={help}>
      <input type="checkbox" checked={on} onChange={(event) => change(event.currentTarget.checked)} />
      <span>{text}</span>
    </label>
  );
}

/** The grey window in numbers. A CT scan also has the usual windows by name. */
function WindowControls({ slices, volume }: SliceBarProps) {
  const window = slices.window.value;
  return (
    <div class="slice-window" role="group" aria-label={t.slices.usual}>
      {volume.modality === Modality.CT ? <UsualWindows slices={slices} /> : null}
      <Typed
        label={t.slices.centre}
        value={window.centre}
        limits={windowLimits.centre}
        take={(centre) => slices.setWindow({ ...window, centre })}
      />
      <Typed
        label={t.slices.width}
        value={window.width}
        limits={windowLimits.width}
        take={(width) => slices.setWindow({ ...window, width })}
      />
    </div>
  );
}

const windowNames = Object.keys(usualWindows) as UsualWindow[];

function UsualWindows({ slices }: { readonly slices: Slices }) {
  const { centre, width } = slices.window.value;
  const usual = windowNames.find((name) => usualWindows[name].centre === centre && usualWindows[name].width === width);
  return (
    <select
      aria-label={t.slices.usual}
      value={usual ?? ""}
      onChange={(event) => {
        const name = event.currentTarget.value as UsualWindow | "";
        if (name !== "") slices.setWindow(usualWindows[name]);
      }}
    >
      <option value="">{t.slices.usualOwn}</option>
      {windowNames.map((name) => (
        <option key={name} value={name}>
          {t.slices.usualWindows[name]}
        </option>
      ))}
    </select>
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

/** A choice of a few values side by side: the browser's radio buttons, styled as a row of buttons. */
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
