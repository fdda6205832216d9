import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Anonymise } from "../../api/anonymise";
import {
  boundsOf,
  fromProposal,
  handles,
  moved,
  partThatGoes,
  rangeOf,
  toBody,
  wholeRegion,
  type Handle,
  type Region,
} from "../../cut/region";
import { eyeOf } from "../../picture/handles";
import type { Box } from "../../picture/project";
import { withClip, type VolumeHeader } from "../../protocol/messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Dialog } from "../dialog";
import { startPolling } from "../polling";
import { Link } from "../router";
import { Notice } from "../shell";
import { useApp } from "../state";
import { Handles, keyOf, nameOf } from "./handles";

export interface CutPanelProps {
  readonly session: ViewerSession;
  readonly dataSetId: string;
  /** Called when the cut is confirmed, with the region to keep and the hash of the volume that it belongs to. */
  readonly onConfirm: (region: Region, volumeHash: string) => void;
}

/** Shows the region to keep in the live picture, as it will look. */
export function CutPanel(props: CutPanelProps) {
  const { facts, failed } = useFacts(props.dataSetId);
  const volume = props.session.volume.value;
  if (facts === null && failed)
    return (
      <section class="glass cut-panel" aria-label={t.cut.title}>
        <h2>{t.cut.title}</h2>
        <Notice kind="bad">{t.problems.unreachable}</Notice>
      </section>
    );
  return volume && props.session.editor.scene.value && facts ? (
    <Chooser {...props} volume={volume} facts={facts} />
  ) : null;
}

const retryMs = 1500;

/** Requests what the server knows about the scan until it responds, because a cut requires it. */
function useFacts(dataSetId: string) {
  const app = useApp();
  const [facts, setFacts] = useState<Anonymise | null>(null);
  const [failed, setFailed] = useState(false);
  useEffect(() => {
    const polling = startPolling(async () => {
      try {
        setFacts(await app.api.anonymise.look(dataSetId));
        polling.stop();
      } catch {
        setFailed(true);
      }
      return retryMs;
    });
    return polling.stop;
  }, [app, dataSetId]);
  return { facts, failed };
}

interface ChooserProps extends CutPanelProps {
  readonly volume: VolumeHeader;
  readonly facts: Anonymise;
}

function Chooser({ session, dataSetId, onConfirm, volume, facts }: ChooserProps) {
  const bounds = useMemo(() => boundsOf(volume), [volume]);
  const proposal = facts.head?.proposal ?? null;
  const [region, setRegion] = useState<Region>(() => (proposal ? fromProposal(proposal, bounds) : wholeRegion(bounds)));
  const [asking, setAsking] = useState(false);
  useFirstView(session, region);
  const change = (next: Region, rest: boolean) => {
    setRegion(next);
    show(session, next, rest);
  };
  const eye = session.editor.scene.value && eyeOf(session.editor.scene.value);
  const percent = Math.round(100 * partThatGoes(region, bounds));
  return (
    <>
      {eye ? <Handles eye={eye} region={region} bounds={bounds} change={change} /> : null}
      <section class="glass cut-panel" aria-label={t.cut.title}>
        <h2>{t.cut.title}</h2>
        <p class={facts.head?.found ? "cut-warning" : ""}>{warningOf(facts)}</p>
        <p class="muted">{t.cut.how}</p>
        <Sliders region={region} bounds={bounds} change={change} />
        <div class="cut-end">
          <p role="status" class="cut-goes">
            {t.cut.goes(percent)}
          </p>
          <div class="cut-buttons">
            {proposal ? (
              <SmallButton text={t.cut.propose} onClick={() => change(fromProposal(proposal, bounds), true)} />
            ) : null}
            <SmallButton text={t.cut.keepAll} onClick={() => change(wholeRegion(bounds), true)} />
            <Link href={`/view/${dataSetId}`} class="button button-small">
              {t.cut.leave}
            </Link>
            <button type="button" class="button button-danger" onClick={() => setAsking(true)}>
              {t.cut.confirmCut}
            </button>
          </div>
        </div>
      </section>
      {asking ? (
        <Confirm
          percent={percent}
          onClose={() => setAsking(false)}
          onConfirm={() => onConfirm(region, volume.contentHash)}
        />
      ) : null}
    </>
  );
}

function SmallButton({ text, onClick }: { readonly text: string; readonly onClick: () => void }) {
  return (
    <button type="button" class="button button-small" onClick={onClick}>
      {text}
    </button>
  );
}

const warningOf = ({ head }: Anonymise): string =>
  head === null ? t.cut.noIdea : head.found ? t.cut.head : t.cut.noHead;

/** Starts with the skin, by which others could recognise the person, and with the proposed region. */
function useFirstView(session: ViewerSession, region: Region): void {
  const begun = useRef(false);
  useEffect(() => {
    if (begun.current) return;
    begun.current = true;
    const skin = session.editor.presets.value.find((preset) => preset.name === "skin");
    if (skin) session.editor.beginWith(skin);
    show(session, region, true);
  }, [session, region]);
}

function show(session: ViewerSession, region: Region, rest: boolean): void {
  const scene = session.editor.scene.value;
  if (!scene) return;
  const { box, planes = [] } = toBody(region);
  session.editor.cutScene(withClip(scene, box, planes), rest);
}

interface SlidersProps {
  readonly region: Region;
  readonly bounds: Box;
  readonly change: (region: Region, rest: boolean) => void;
}

/** A slider per handle, as the alternative to dragging. */
function Sliders({ region, bounds, change }: SlidersProps) {
  const { plane } = region;
  const ofHandle = (handle: Handle) => {
    // The slider covers the full range, so that the thumb shows the position of the face. A value that would close the
    // box is ignored.
    const range =
      handle.kind === "plane"
        ? rangeOf(handle, region, bounds)
        : { low: bounds.low[handle.axis], high: bounds.high[handle.axis], at: region[handle.side][handle.axis] };
    return (
      <Slider
        key={keyOf(handle)}
        label={nameOf(handle)}
        {...range}
        valueText={t.cut.mm}
        change={(to, rest) => change(moved(handle, to, region, bounds), rest)}
      />
    );
  };
  return (
    <fieldset class="cut-sliders">
      <legend>{t.cut.panel}</legend>
      <label class="switch">
        <input
          type="checkbox"
          checked={plane.on}
          onChange={(event) => change({ ...region, plane: { ...plane, on: event.currentTarget.checked } }, true)}
        />
        {t.cut.facePlane}
      </label>
      {plane.on ? (
        <>
          <Slider
            label={t.cut.tilt}
            low={0}
            high={90}
            at={plane.tilt}
            valueText={t.cut.degrees}
            change={(tilt, rest) => change({ ...region, plane: { ...plane, tilt } }, rest)}
          />
          <Slider
            label={t.cut.aside}
            low={-60}
            high={60}
            at={plane.aside}
            valueText={t.cut.degrees}
            change={(aside, rest) => change({ ...region, plane: { ...plane, aside } }, rest)}
          />
          {handles.filter(({ kind }) => kind === "plane").map(ofHandle)}
        </>
      ) : null}
      {handles.filter(({ kind }) => kind === "face").map(ofHandle)}
    </fieldset>
  );
}

interface SliderProps {
  readonly label: string;
  readonly low: number;
  readonly high: number;
  readonly at: number;
  readonly valueText: (value: number) => string;
  readonly change: (value: number, rest: boolean) => void;
}

function Slider({ label, low, high, at, valueText, change }: SliderProps) {
  const value = Math.round(at);
  return (
    <label class="cut-slider">
      <span>{label}</span>
      <input
        type="range"
        min={Math.floor(low)}
        max={Math.ceil(high)}
        step={1}
        value={value}
        aria-valuetext={valueText(value)}
        onInput={(event) => change(event.currentTarget.valueAsNumber, false)}
        onChange={(event) => change(event.currentTarget.valueAsNumber, true)}
      />
      <output>{valueText(value)}</output>
    </label>
  );
}

function Confirm({
  percent,
  onClose,
  onConfirm,
}: {
  readonly percent: number;
  readonly onClose: () => void;
  readonly onConfirm: () => void;
}) {
  const [understood, setUnderstood] = useState(false);
  return (
    <Dialog title={t.cut.confirmTitle} onClose={onClose}>
      <Notice kind="info">{percent === 0 ? t.cut.confirmNothing : t.cut.goes(percent)}</Notice>
      <p>{t.cut.confirmLead}</p>
      <p>{t.cut.confirmMarks}</p>
      <p>{t.cut.confirmAfter}</p>
      <label class="switch">
        <input type="checkbox" checked={understood} onChange={(event) => setUnderstood(event.currentTarget.checked)} />
        {t.cut.understood}
      </label>
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>
          {t.cut.leave}
        </button>
        <button type="button" class="button button-danger" disabled={!understood} onClick={onConfirm}>
          {t.cut.confirm}
        </button>
      </div>
    </Dialog>
  );
}
