import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Anonymise } from "../../api/anonymise";
import { bounds_of, from_proposal, handles, moved, part_that_goes, range_of, to_body, whole, type Handle, type Region } from "../../cut/region";
import { eye_of } from "../../picture/handles";
import type { Box } from "../../picture/project";
import { with_clip, type VolumeHeader } from "../../protocol/messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Dialog } from "../dialog";
import { Link } from "../router";
import { Notice } from "../shell";
import { useApp } from "../state";
import { Handles, key_of, name_of } from "./handles";

export interface CutPanelProps {
  readonly session: ViewerSession;
  readonly data_set_id: string;
  /** The cut was confirmed: of the volume with that hash, what is to be kept. */
  readonly onConfirm: (region: Region, volume_hash: string) => void;
}

/** Over the live picture: what is to be kept, as it will look. */
export function CutPanel(props: CutPanelProps) {
  const app = useApp();
  const [facts, set_facts] = useState<Anonymise | null>(null);
  useEffect(() => {
    app.api.anonymise.look(props.data_set_id).then(set_facts, () => undefined); // without them nothing is proposed
  }, [app, props.data_set_id]);
  const volume = props.session.volume.value;
  return volume && props.session.scene.value && facts ? <Chooser {...props} volume={volume} facts={facts} /> : null;
}

interface ChooserProps extends CutPanelProps {
  readonly volume: VolumeHeader;
  readonly facts: Anonymise;
}

function Chooser({ session, data_set_id, onConfirm, volume, facts }: ChooserProps) {
  const bounds = useMemo(() => bounds_of(volume), [volume]);
  const proposal = facts.head?.proposal ?? null;
  const [region, set_region] = useState<Region>(() => (proposal ? from_proposal(proposal, bounds) : whole(bounds)));
  const [asking, set_asking] = useState(false);
  const skin = useRef(false);

  const change = (next: Region, rest: boolean) => {
    set_region(next);
    show(session, next, rest);
  };
  useEffect(() => {
    if (skin.current) return;
    skin.current = true;
    // Skin is what others would know somebody by.
    const look = session.presets.value.find((preset) => preset.name === "skin");
    if (look) session.begin_with(look);
    show(session, region, true);
  }, [session, region]);

  const eye = session.scene.value && eye_of(session.scene.value);
  const percent = Math.round(100 * part_that_goes(region, bounds));
  const warning = facts.head === null ? t.cut.no_idea : facts.head.found ? t.cut.head : t.cut.no_head;
  return (
    <>
      {eye ? <Handles eye={eye} region={region} bounds={bounds} change={change} /> : null}
      <section class="glass cut-panel" aria-label={t.cut.title}>
        <h2>{t.cut.title}</h2>
        <p class={facts.head?.found ? "cut-warning" : ""}>{warning}</p>
        <p class="muted">{t.cut.how}</p>
        <Sliders region={region} bounds={bounds} change={change} />
        <div class="cut-end">
          <p role="status" class="cut-goes">{t.cut.goes(percent)}</p>
          <div class="cut-buttons">
            <button type="button" class="button button-small" onClick={() => change(whole(bounds), true)}>{t.cut.keep_all}</button>
            {proposal ? <button type="button" class="button button-small" onClick={() => change(from_proposal(proposal, bounds), true)}>{t.cut.propose}</button> : null}
            <Link href={`/view/${data_set_id}`} class="button button-small">{t.cut.leave}</Link>
            <button type="button" class="button button-danger" onClick={() => set_asking(true)}>{t.cut.go_on}</button>
          </div>
        </div>
      </section>
      {asking ? <Confirm percent={percent} onClose={() => set_asking(false)} onConfirm={() => onConfirm(region, volume.contentHash)} /> : null}
    </>
  );
}

function show(session: ViewerSession, region: Region, rest: boolean): void {
  const scene = session.scene.value;
  if (!scene) return;
  const { box, planes = [] } = to_body(region);
  session.cut_scene(with_clip(scene, box, planes), rest);
}

interface SlidersProps {
  readonly region: Region;
  readonly bounds: Box;
  readonly change: (region: Region, rest: boolean) => void;
}

/** The second way to each handle. */
function Sliders({ region, bounds, change }: SlidersProps) {
  const { plane } = region;
  const of_handle = (handle: Handle) => {
    // The whole way, so that the thumb stands where the face is; what would close the box is not taken.
    const range = handle.kind === "plane" ? range_of(handle, region, bounds) : { low: bounds.low[handle.axis], high: bounds.high[handle.axis], at: region[handle.side][handle.axis] };
    return <Slider key={key_of(handle)} label={name_of(handle)} {...range} said={t.cut.mm} change={(to, rest) => change(moved(handle, to, region, bounds), rest)} />;
  };
  return (
    <fieldset class="cut-sliders">
      <legend>{t.cut.panel}</legend>
      <label class="switch">
        <input type="checkbox" checked={plane.on} onChange={(event) => change({ ...region, plane: { ...plane, on: event.currentTarget.checked } }, true)} />
        {t.cut.face_plane}
      </label>
      {plane.on ? (
        <>
          <Slider label={t.cut.tilt} low={0} high={90} at={plane.tilt} said={t.cut.degrees} change={(tilt, rest) => change({ ...region, plane: { ...plane, tilt } }, rest)} />
          <Slider label={t.cut.aside} low={-60} high={60} at={plane.aside} said={t.cut.degrees} change={(aside, rest) => change({ ...region, plane: { ...plane, aside } }, rest)} />
          {handles.filter(({ kind }) => kind === "plane").map(of_handle)}
        </>
      ) : null}
      {handles.filter(({ kind }) => kind === "face").map(of_handle)}
    </fieldset>
  );
}

interface SliderProps {
  readonly label: string;
  readonly low: number;
  readonly high: number;
  readonly at: number;
  readonly said: (value: number) => string;
  readonly change: (value: number, rest: boolean) => void;
}

function Slider({ label, low, high, at, said, change }: SliderProps) {
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
        aria-valuetext={said(value)}
        onInput={(event) => change(event.currentTarget.valueAsNumber, false)}
        onChange={(event) => change(event.currentTarget.valueAsNumber, true)}
      />
      <output>{said(value)}</output>
    </label>
  );
}

function Confirm({ percent, onClose, onConfirm }: { readonly percent: number; readonly onClose: () => void; readonly onConfirm: () => void }) {
  const [understood, set_understood] = useState(false);
  return (
    <Dialog title={t.cut.confirm_title} onClose={onClose}>
      <Notice kind="info">{percent === 0 ? t.cut.confirm_nothing : t.cut.goes(percent)}</Notice>
      <p>{t.cut.confirm_lead}</p>
      <p>{t.cut.confirm_after}</p>
      <label class="switch">
        <input type="checkbox" checked={understood} onChange={(event) => set_understood(event.currentTarget.checked)} />
        {t.cut.understood}
      </label>
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>{t.cut.leave}</button>
        <button type="button" class="button button-danger" disabled={!understood} onClick={onConfirm}>{t.cut.confirm}</button>
      </div>
    </Dialog>
  );
}
