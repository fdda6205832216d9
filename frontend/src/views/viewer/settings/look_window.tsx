import { useRef, useState } from "preact/hooks";
import type { TransferFunction } from "../../../protocol/gen/api/proto/scene_pb";
import { Modality } from "../../../protocol/messages";
import { hex_of, hue_of, scaled, strength_of } from "../../../scene/colour";
import * as transfer from "../../../scene/transfer";
import { local } from "../../../storage";
import { t } from "../../../texts";
import { Icon } from "../../icons";
import { ColourControl, NumberControl, type WindowProps } from "./controls";
import { PointControls } from "./point_controls";
import { TransferGraph } from "./transfer_graph";

const key = "diaphane.histogram";

/** The transfer function: materials by value, each with its opacity and its looks. */
export function LookWindow({ session, leads }: WindowProps) {
  const text = t.settings.look;
  const scene = session.scene.value;
  const volume = session.volume.value;
  const [wanted, set_wanted] = useState({ channel: 0, point: 0 });
  const [logarithmic, set_logarithmic] = useState(() => local.getItem(key) !== "linear");
  if (!scene) return null;
  const { channels } = transfer.transfer_of(scene);
  const index = Math.min(wanted.channel, channels.length - 1);
  const channel = channels[index];
  const point = Math.min(wanted.point, (channel?.opacity.length ?? 1) - 1);
  const range = transfer.shown_range(transfer.transfer_of(scene), volume?.minimum ?? 0, volume?.maximum ?? 1);
  const unit = volume?.modality === Modality.CT ? text.hounsfield : "";
  const rest = () => session.rest();
  const choose = (next: number) => set_wanted({ channel: index, point: next });

  const add_point = (at?: { readonly value: number; readonly opacity: number }) => {
    const added = channel && transfer.add_point(scene, index, at?.value ?? Math.round(transfer.roomiest_value(channel)), at?.opacity);
    if (!added) return;
    session.change("point added", () => added.scene);
    choose(added.index);
    rest();
  };
  const remove_point = () => {
    session.change("point removed", (now) => transfer.remove_point(now, index, point));
    choose(Math.max(0, point - 1));
    rest();
  };
  const move_point = (which: number, value: number, opacity: number, held: boolean) =>
    session.change(`point ${index} ${which}`, (now) => transfer.move_point(now, index, which, { value, opacity }), held);
  const set = (what: string, material: transfer.Material, held: boolean) =>
    session.change(`${what} ${index}`, (now) => transfer.set_material(now, index, material), held);
  const add_channel = () => {
    session.change("channel added", (now) => transfer.add_channel(now, text.new_name(channels.length + 1), { low: volume?.minimum ?? 0, high: volume?.maximum ?? 100 }));
    set_wanted({ channel: channels.length, point: 1 });
    rest();
  };
  return (
    <>
      <div class="channels" role="group" aria-label={text.channels}>
        {channels.map((one, i) => {
          const name = text.channel(one.name, i + 1);
          return (
            <span key={i} class="channel" data-channel={i}>
              <input type="checkbox" aria-label={text.shown(name)} checked={!one.disabled}
                onChange={(event) => {
                  const disabled = !event.currentTarget.checked;
                  session.change(`shown ${i}`, (now) => transfer.set_material(now, i, { disabled }));
                  rest();
                }} />
              <button type="button" aria-pressed={i === index} onClick={() => set_wanted({ channel: i, point: 0 })}>
                <svg class="swatch" viewBox="0 0 10 10" aria-hidden="true"><circle cx="5" cy="5" r="4.500" fill={hex_of(one.diffuse)} /></svg>
                {name}
              </button>
            </span>
          );
        })}
        <button type="button" class="icon-button" aria-label={text.add} title={text.add} disabled={channels.length >= transfer.most_channels} onClick={add_channel}>
          <Icon name="plus" />
        </button>
      </div>
      <TransferGraph transfer={transfer.transfer_of(scene)} range={range} histogram={session.histogram.value} logarithmic={logarithmic} channel={index}
        point={point} leads={leads} choose={choose} move={move_point} rest={rest} add={add_point} remove={remove_point} />
      <p class="hint" id="graph-help">{text.graph_help} <span class="for-keys">{text.graph_keys}</span></p>
      {channel ? <PointControls channel={channel} point={point} unit={unit} range={range} choose={choose} move={move_point} rest={rest} add={() => add_point()} remove={remove_point} /> : null}
      {channel ? <ColourControl label={text.colour} value={channel.diffuse} rest={rest} change={(diffuse, held) => set("colour", { diffuse }, held)} /> : null}
      <NumberControl label={text.density} unit={text.per_mm} value={transfer.transfer_of(scene).extinctionPerMm} limits={transfer.density_limits}
        slide={{ low: 0.01, high: 20 }} logarithmic rest={rest} change={(density, held) => session.change("density", (now) => transfer.set_density(now, density), held)} />
      <Shift session={session} leads={leads} unit={unit} reach={Math.round((range.high - range.low) / 4)} />
      <details class="more">
        <summary>{t.settings.more}</summary>
        {session.histogram.value ? (
          <label class="control">
            <span class="control-name">{text.scale}</span>
            <select class="choice" value={logarithmic ? "logarithmic" : "linear"} onChange={(event) => {
              set_logarithmic(event.currentTarget.value === "logarithmic");
              local.setItem(key, event.currentTarget.value);
            }}>
              <option value="logarithmic">{text.logarithmic}</option>
              <option value="linear">{text.linear}</option>
            </select>
          </label>
        ) : <p class="hint">{text.no_histogram}</p>}
        <p class="hint">{text.overlap}</p>
        {channel ? <MaterialControls session={session} leads={leads} index={index} onRemoved={() => set_wanted({ channel: 0, point: 0 })} /> : null}
      </details>
    </>
  );
}

/** What a material is besides its colour. */
function MaterialControls({ session, index, onRemoved }: WindowProps & { readonly index: number; readonly onRemoved: () => void }) {
  const text = t.settings.look;
  const channels = session.scene.value ? transfer.channels_of(session.scene.value) : [];
  const channel = channels[index];
  if (!channel) return null;
  const rest = () => session.rest();
  const set = (what: string, material: transfer.Material, held: boolean) =>
    session.change(`${what} ${index}`, (now) => transfer.set_material(now, index, material), held);
  const glow = strength_of(channel.emission);
  return (
    <>
      <label class="control">
        <span class="control-name">{text.name}</span>
        <input type="text" class="name" maxLength={transfer.longest_name} value={channel.name} onChange={(event) => {
          set("name", { name: event.currentTarget.value.trim() }, false);
          rest();
        }} />
      </label>
      <ColourControl label={text.highlight} value={channel.specular} rest={rest} change={(specular, held) => set("highlight", { specular }, held)} />
      <NumberControl label={text.gloss} value={channel.gloss} limits={transfer.unit_limits} step={0.01} rest={rest} change={(gloss, held) => set("gloss", { gloss }, held)} />
      <p class="hint">{text.surface_hint}</p>
      <NumberControl label={text.glow} value={glow} limits={transfer.emission_limits} slide={{ low: 0, high: 10 }} step={0.05} rest={rest}
        change={(strength, held) => set("glow", { emission: scaled(hue_of(glow > 0 ? channel.emission : channel.diffuse), strength) }, held)} />
      {glow > 0 ? (
        <ColourControl label={text.glow_colour} value={hue_of(channel.emission)} rest={rest} change={(hue, held) => set("glow colour", { emission: scaled(hue_of(hue), glow) }, held)} />
      ) : null}
      {channels.length > 1 ? (
        <p><button type="button" class="button button-small" onClick={() => {
          session.change("channel removed", (now) => transfer.remove_channel(now, index));
          rest();
          onRemoved();
        }}>{text.remove(text.channel(channel.name, index + 1))}</button></p>
      ) : null}
    </>
  );
}

/** The window of the whole function along the values. Measured from where it was before it was taken hold of. */
function Shift({ session, unit, reach }: WindowProps & { readonly unit: string; readonly reach: number }) {
  const way = useRef<{ base: TransferFunction; result: TransferFunction; by: number } | null>(null);
  const scene = session.scene.value;
  if (!scene) return null;
  const now = transfer.transfer_of(scene);
  // Changed by anything else, it begins anew from what is there.
  const current = way.current?.result === now ? way.current : { base: now, result: now, by: 0 };
  return (
    <NumberControl label={t.settings.look.shift} unit={unit} value={current.by} limits={{ low: -reach, high: reach }} rest={() => session.rest()}
      change={(by, held) => {
        const result = transfer.shifted(current.base, by);
        way.current = { base: current.base, result, by };
        session.change("shift", (before) => ({ ...before, transferFunction: result }), held);
      }} />
  );
}
