import { bounds_of } from "../../../cut/region";
import type { Box } from "../../../picture/project";
import { Slices_Colouring } from "../../../protocol/gen/api/proto/scene_pb";
import * as cuts from "../../../scene/cuts";
import { t } from "../../../texts";
import { Icon } from "../../icons";
import { KeepHandles, NumberControl, Switch, type PictureWindowProps, type WindowProps } from "./controls";

interface PartProps extends WindowProps {
  readonly bounds: Box;
}

/** What is cut away, and slices in the picture. */
export function CutsWindow(props: PictureWindowProps) {
  const volume = props.session.volume.value;
  if (!volume || !props.session.scene.value) return null;
  const bounds = bounds_of(volume);
  return (
    <>
      <p class="hint">{t.settings.picture.cuts}</p>
      <KeepHandles picture={props.picture} which="cuts" />
      <BoxPart {...props} bounds={bounds} />
      <PlanesPart {...props} bounds={bounds} />
      {props.session.slices.access.value === "none" ? null : <SlicesPart {...props} bounds={bounds} grey={{ centre: volume.windowCenter, width: volume.windowWidth }} />}
    </>
  );
}

function BoxPart({ session, bounds }: PartProps) {
  const text = t.settings.cuts;
  const scene = session.scene.value;
  if (!scene) return null;
  const box = cuts.box_of(scene, bounds);
  return (
    <>
      <h3>{text.box}</h3>
      {cuts.axes.flatMap((axis) => (["low", "high"] as const).map((side) => (
        <NumberControl key={axis + side} label={text.faces[axis][side]} unit={t.settings.mm} value={box[side][axis]} limits={cuts.face_limits(scene, bounds, axis, side)}
          slide={{ low: bounds.low[axis], high: bounds.high[axis] }} step={0.5} rest={() => session.rest()}
          change={(to, held) => session.change(`face ${axis} ${side}`, (now) => cuts.move_face(now, bounds, axis, side, to), held)} />
      )))}
    </>
  );
}

function PlanesPart({ session, bounds }: PartProps) {
  const text = t.settings.cuts;
  const scene = session.scene.value;
  if (!scene) return null;
  const planes = cuts.planes_of(scene);
  const reach = Math.ceil(cuts.reach_of(bounds));
  const rest = () => session.rest();
  const move = (index: number, to: Partial<cuts.Plane>, held: boolean) => session.change(`plane ${index}`, (now) => cuts.move_plane(now, bounds, index, to), held);
  return (
    <details class="more" open={planes.length > 0}>
      <summary>{text.planes}</summary>
      {planes.map((plane, i) => (
        <div key={i} class="plane" role="group" aria-label={text.plane(i + 1)}>
          <p class="point-head">
            <strong>{text.plane(i + 1)}</strong>
            <button type="button" class="icon-button" aria-label={text.remove_plane(i + 1)} title={text.remove_plane(i + 1)} onClick={() => {
              session.change("plane removed", (now) => cuts.remove_plane(now, i));
              rest();
            }}><Icon name="trash" /></button>
          </p>
          <NumberControl label={text.turn} unit={t.settings.degrees} value={plane.right} limits={{ low: -180, high: 180 }} rest={rest} change={(right, held) => move(i, { right }, held)} />
          <NumberControl label={text.tilt} unit={t.settings.degrees} value={plane.up} limits={{ low: -90, high: 90 }} rest={rest} change={(up, held) => move(i, { up }, held)} />
          <NumberControl label={text.offset} unit={t.settings.mm} value={plane.offset} limits={{ low: -reach, high: reach }} step={0.5} rest={rest} change={(offset, held) => move(i, { offset }, held)} />
        </div>
      ))}
      {planes.length < cuts.most_planes ? (
        <p><button type="button" class="button button-small" onClick={() => {
          session.change("plane added", cuts.add_plane);
          rest();
        }}><Icon name="plus" />{text.add_plane}</button></p>
      ) : null}
      <Switch label={text.cuts_light} on={cuts.cuts_light(scene)} change={(on) => {
        session.change("cuts light", (now) => cuts.set_cuts_light(now, on));
        rest();
      }} />
    </details>
  );
}

function SlicesPart({ session, bounds, grey }: PartProps & { readonly grey: cuts.Grey }) {
  const text = t.settings.cuts;
  const scene = session.scene.value;
  if (!scene) return null;
  const slices = cuts.slices_of(scene);
  const shown = cuts.slice_names.filter((name) => slices[name]?.shown);
  const rest = () => session.rest();
  const once = (what: string, edit: Parameters<typeof session.change>[1]) => {
    session.change(what, edit);
    rest();
  };
  return (
    <>
      <h3>{text.slices}</h3>
      {cuts.slice_names.map((name) => {
        const axis = cuts.slice_axes[name];
        const slice = slices[name];
        return (
          <div key={name} data-slice={name}>
            <Switch label={text.show(text.slice[name])} on={slice?.shown ?? false} change={(on) => once(`slice ${name}`, (now) => cuts.set_slice(now, bounds, grey, name, { shown: on }))} />
            {slice?.shown ? (
              <NumberControl label={text.position(text.slice[name])} unit={t.settings.mm} value={slice.position} limits={{ low: bounds.low[axis], high: bounds.high[axis] }} step={0.5} rest={rest}
                change={(position, held) => session.change(`slice at ${name}`, (now) => cuts.set_slice(now, bounds, grey, name, { position }), held)} />
            ) : null}
          </div>
        );
      })}
      {shown.length > 0 ? (
        <>
          <Switch label={text.alone} on={slices.alone} change={(alone) => once("slices alone", (now) => cuts.set_alone(now, grey, alone))} />
          <label class="control">
            <span class="control-name">{text.colouring}</span>
            <select class="choice" value={slices.colouring === Slices_Colouring.TRANSFER ? "transfer" : "grey"}
              onChange={(event) => {
                const transfer = event.currentTarget.value === "transfer";
                once("slice colours", (now) => cuts.set_colouring(now, grey, transfer));
              }}>
              <option value="grey">{text.grey}</option>
              <option value="transfer">{text.transfer}</option>
            </select>
          </label>
          {slices.colouring === Slices_Colouring.TRANSFER ? null : (
            <>
              <NumberControl label={text.level} value={slices.windowCentre} limits={cuts.window_centre_limits} slide={{ low: -1000, high: 2000 }} rest={rest}
                change={(centre, held) => session.change("level", (now) => cuts.set_window(now, grey, { centre }), held)} />
              <NumberControl label={text.window} value={slices.windowWidth} limits={cuts.window_width_limits} slide={{ low: 1, high: 4000 }} logarithmic rest={rest}
                change={(width, held) => session.change("window", (now) => cuts.set_window(now, grey, { width }), held)} />
            </>
          )}
        </>
      ) : null}
    </>
  );
}
