import { boundsOf } from "../../../cut/region";
import type { Box } from "../../../picture/project";
import * as cuts from "../../../scene/cuts";
import { t } from "../../../texts";
import { IconButton } from "../../icon_button";
import { Icon } from "../../icons";
import { KeepHandles, NumberControl, Switch, type PictureWindowProps, type WindowProps } from "./controls";
import { sceneEdits } from "./scene_edits";
import { SlicesPart } from "./slices_part";

interface PartProps extends WindowProps {
  readonly bounds: Box;
}

/** The clip box and planes, and the slices that are drawn in the picture. */
export function CutsWindow(props: PictureWindowProps) {
  const volume = props.session.volume.value;
  if (!volume || !props.session.editor.scene.value) return null;
  const bounds = boundsOf(volume);
  return (
    <>
      <p class="hint">{t.settings.picture.cuts}</p>
      <KeepHandles picture={props.picture} which="cuts" />
      <TablePart session={props.session} />
      <BoxPart {...props} bounds={bounds} />
      <PlanesPart {...props} bounds={bounds} />
      {props.session.slices.access.value === "none" ? null : (
        <SlicesPart
          session={props.session}
          bounds={bounds}
          grey={{ centre: volume.windowCenter, width: volume.windowWidth }}
        />
      )}
    </>
  );
}

function TablePart({ session }: Pick<PartProps, "session">) {
  const text = t.settings.cuts;
  const scene = session.editor.scene.value;
  if (!scene) return null;
  return (
    <>
      <Switch
        label={text.table}
        on={cuts.showsTable(scene)}
        change={sceneEdits(session.editor).once("table", cuts.setShowsTable)}
      />
      <p class="hint">{text.tableHint}</p>
    </>
  );
}

function BoxPart({ session, bounds }: PartProps) {
  const text = t.settings.cuts;
  const scene = session.editor.scene.value;
  if (!scene) return null;
  const box = cuts.boxOf(scene, bounds);
  return (
    <>
      <h3>{text.box}</h3>
      {cuts.axes.flatMap((axis) =>
        (["low", "high"] as const).map((side) => (
          <NumberControl
            key={axis + side}
            label={text.faces[axis][side]}
            unit={t.settings.mm}
            value={box[side][axis]}
            limits={cuts.faceLimits(scene, bounds, axis, side)}
            slide={{ low: bounds.low[axis], high: bounds.high[axis] }}
            step={0.5}
            rest={() => session.editor.rest()}
            change={(to, held) =>
              session.editor.change(`face ${axis} ${side}`, (now) => cuts.moveFace(now, bounds, axis, side, to), held)
            }
          />
        )),
      )}
    </>
  );
}

function PlanesPart({ session, bounds }: PartProps) {
  const text = t.settings.cuts;
  const scene = session.editor.scene.value;
  if (!scene) return null;
  const planes = cuts.planesOf(scene);
  const { apply, once } = sceneEdits(session.editor);
  return (
    <details class="more" open={planes.length > 0}>
      <summary>{text.planes}</summary>
      {planes.map((plane, i) => (
        <PlaneControls key={i} plane={plane} index={i} session={session} bounds={bounds} />
      ))}
      {planes.length < cuts.mostPlanes ? (
        <p>
          <button type="button" class="button button-small" onClick={() => apply("plane added", cuts.addPlane)}>
            <Icon name="plus" />
            {text.addPlane}
          </button>
        </p>
      ) : null}
      <Switch label={text.cutsLight} on={cuts.cutsLight(scene)} change={once("cuts light", cuts.setCutsLight)} />
    </details>
  );
}

interface PlaneControlsProps extends Pick<PartProps, "session" | "bounds"> {
  readonly plane: cuts.Plane;
  readonly index: number;
}

function PlaneControls({ plane, index, session, bounds }: PlaneControlsProps) {
  const text = t.settings.cuts;
  const { apply, rest } = sceneEdits(session.editor);
  const reach = Math.ceil(cuts.reachOf(bounds));
  const move = (to: Partial<cuts.Plane>, held: boolean) =>
    session.editor.change(`plane ${index}`, (now) => cuts.movePlane(now, bounds, index, to), held);
  return (
    <div class="plane" role="group" aria-label={text.plane(index + 1)}>
      <p class="point-head">
        <strong>{text.plane(index + 1)}</strong>
        <IconButton
          icon="trash"
          label={text.removePlane(index + 1)}
          onClick={() => apply("plane removed", (now) => cuts.removePlane(now, index))}
        />
      </p>
      <NumberControl
        label={text.turn}
        unit={t.settings.degrees}
        value={plane.right}
        limits={{ low: -180, high: 180 }}
        rest={rest}
        change={(right, held) => move({ right }, held)}
      />
      <NumberControl
        label={text.tilt}
        unit={t.settings.degrees}
        value={plane.up}
        limits={{ low: -90, high: 90 }}
        rest={rest}
        change={(up, held) => move({ up }, held)}
      />
      <NumberControl
        label={text.offset}
        unit={t.settings.mm}
        value={plane.offset}
        limits={{ low: -reach, high: reach }}
        step={0.5}
        rest={rest}
        change={(offset, held) => move({ offset }, held)}
      />
    </div>
  );
}
