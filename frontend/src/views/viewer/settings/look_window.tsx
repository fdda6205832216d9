import { useRef, useState } from "preact/hooks";
import type { Channel, TransferFunction } from "../../../protocol/gen/api/proto/scene_pb";
import { Modality } from "../../../protocol/messages";
import { comfortLimits } from "../../../scene/comfort";
import * as transfer from "../../../scene/transfer";
import { local } from "../../../storage";
import { t } from "../../../texts";
import { IconButton } from "../../icon_button";
import { ColourControl, NumberControl, SelectControl, type WindowProps } from "./controls";
import { ListChip } from "./list_chip";
import { MaterialControls } from "./material_controls";
import { PointControls } from "./point_controls";
import { sceneEdits } from "./scene_edits";
import { clampedSelection, transferEdits, type Selection, type TransferEdits } from "./transfer_edits";
import { TransferGraph } from "./transfer_graph";

const scaleKey = "diaphane.histogram";
type HistogramScale = "logarithmic" | "linear";
const firstPoint: Selection = { channel: 0, point: 0 };

/** The transfer function: materials by value, each with its opacity and appearance. */
export function LookWindow({ session, leads }: WindowProps) {
  const text = t.settings.look;
  const scene = session.editor.scene.value;
  const volume = session.volume.value;
  const [requested, select] = useState(firstPoint);
  const [scale, setScale] = useHistogramScale();
  if (!scene) return null;
  const all = transfer.transferOf(scene);
  const selected = clampedSelection(all.channels, requested);
  const channel = all.channels[selected.channel];
  const range = transfer.shownRange(all, volume?.minimum ?? 0, volume?.maximum ?? 1);
  const unit = volume?.modality === Modality.CT ? text.hounsfield : "";
  const edits = transferEdits(session.editor, scene, selected, select);
  const pointEdits = {
    point: selected.point,
    range,
    choose: edits.choosePoint,
    move: edits.movePoint,
    rest: edits.rest,
    remove: edits.removePoint,
  };
  const values = { low: volume?.minimum ?? 0, high: volume?.maximum ?? 100 };
  return (
    <>
      <Comfort session={session} leads={leads} />
      <ChannelList
        channels={all.channels}
        chosen={selected.channel}
        choose={(index) => select({ channel: index, point: 0 })}
        show={edits.showChannel}
        add={() => edits.addChannel(text.newName(all.channels.length + 1), values)}
      />
      <TransferGraph
        {...pointEdits}
        transfer={all}
        histogram={session.histogram.value}
        logarithmic={scale === "logarithmic"}
        channel={selected.channel}
        leads={leads}
        add={edits.addPoint}
      />
      {session.histogram.value ? null : <p class="hint">{text.noHistogram}</p>}
      <GraphHelp />
      {channel ? <PointControls {...pointEdits} channel={channel} unit={unit} add={() => edits.addPoint()} /> : null}
      {channel ? <MaterialColour channel={channel} edits={edits} /> : null}
      <Density session={session} leads={leads} />
      <Shift session={session} leads={leads} unit={unit} reach={Math.round((range.high - range.low) / 4)} />
      <details class="more">
        <summary>{t.settings.more}</summary>
        {session.histogram.value ? <ScaleChoice scale={scale} choose={setScale} /> : null}
        <p class="hint">{text.overlap}</p>
        {channel ? (
          <MaterialControls session={session} index={selected.channel} onRemoved={() => select(firstPoint)} />
        ) : null}
      </details>
    </>
  );
}

/** The scale of the histogram, which this browser remembers. */
function useHistogramScale(): [HistogramScale, (scale: HistogramScale) => void] {
  const [scale, setScale] = useState<HistogramScale>(() =>
    local.getItem(scaleKey) === "linear" ? "linear" : "logarithmic",
  );
  const choose = (next: HistogramScale) => {
    setScale(next);
    local.setItem(scaleKey, next);
  };
  return [scale, choose];
}

function ScaleChoice({
  scale,
  choose,
}: {
  readonly scale: HistogramScale;
  readonly choose: (scale: HistogramScale) => void;
}) {
  const text = t.settings.look;
  return (
    <SelectControl
      label={text.scale}
      value={scale}
      options={[
        ["logarithmic", text.logarithmic],
        ["linear", text.linear],
      ]}
      change={choose}
    />
  );
}

interface ChannelListProps {
  readonly channels: readonly Channel[];
  readonly chosen: number;
  readonly choose: (index: number) => void;
  readonly show: (index: number, shown: boolean) => void;
  readonly add: () => void;
}

function ChannelList({ channels, chosen, choose, show, add }: ChannelListProps) {
  const text = t.settings.look;
  return (
    <div class="channels" role="group" aria-label={text.channels}>
      {channels.map((one, i) => {
        const name = text.channel(one.name, i + 1);
        return (
          <span key={i} class="channel" data-channel={i}>
            <ListChip
              name={name}
              colour={one.diffuse}
              chosen={i === chosen}
              choose={() => choose(i)}
              on={!one.disabled}
              turn={(on) => show(i, on)}
              turnLabel={text.shown(name)}
            />
          </span>
        );
      })}
      <IconButton icon="plus" label={text.add} disabled={channels.length >= transfer.mostChannels} onClick={add} />
    </div>
  );
}

function GraphHelp() {
  return (
    <p class="hint" id="graph-help">
      {t.settings.look.graphHelp} <span class="for-keys">{t.settings.look.graphKeys}</span>
    </p>
  );
}

function MaterialColour({ channel, edits }: { readonly channel: Channel; readonly edits: TransferEdits }) {
  return (
    <ColourControl
      label={t.settings.look.colour}
      value={channel.diffuse}
      rest={edits.rest}
      change={(diffuse, held) => edits.setMaterial("colour", { diffuse }, held)}
    />
  );
}

/** How blood and bone are coloured, if the scene shows any. */
function Comfort({ session }: WindowProps) {
  const { editor } = session;
  const text = t.settings.look.comfort;
  if (!editor.hasComfort()) return null;
  return (
    <div class="comfort">
      <NumberControl
        label={text.name}
        value={editor.comfort()}
        limits={comfortLimits}
        step={0.1}
        rest={() => editor.rest()}
        change={(value, held) => editor.setComfort(value, held)}
      />
      <p class="hint">{text.help}</p>
    </div>
  );
}

function Density({ session }: WindowProps) {
  const scene = session.editor.scene.value;
  if (!scene) return null;
  const { live, rest } = sceneEdits(session.editor);
  return (
    <NumberControl
      label={t.settings.look.density}
      unit={t.settings.look.perMm}
      value={transfer.transferOf(scene).extinctionPerMm}
      limits={transfer.densityLimits}
      slide={{ low: 0.01, high: 20 }}
      logarithmic
      rest={rest}
      change={live("density", transfer.setDensity)}
    />
  );
}

/**
 * Moves all points along the values. The distance is measured from the function before the slider
 * was grabbed.
 */
function Shift({ session, unit, reach }: WindowProps & { readonly unit: string; readonly reach: number }) {
  const lastShift = useRef<{ base: TransferFunction; result: TransferFunction; by: number } | null>(null);
  const scene = session.editor.scene.value;
  if (!scene) return null;
  const now = transfer.transferOf(scene);
  // Any other change of the function starts the distance again from zero.
  const current = lastShift.current?.result === now ? lastShift.current : { base: now, result: now, by: 0 };
  return (
    <NumberControl
      label={t.settings.look.shift}
      unit={unit}
      value={current.by}
      limits={{ low: -reach, high: reach }}
      rest={() => session.editor.rest()}
      change={(by, held) => {
        const result = transfer.shifted(current.base, by);
        lastShift.current = { base: current.base, result, by };
        session.editor.change("shift", (before) => ({ ...before, transferFunction: result }), held);
      }}
    />
  );
}
