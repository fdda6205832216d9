import type { Box } from "../../../picture/project";
import { Slices_Colouring as SlicesColouring } from "../../../protocol/gen/api/proto/scene_pb";
import * as cuts from "../../../scene/cuts";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { NumberControl, SelectControl, Switch } from "./controls";
import { sceneEdits } from "./scene_edits";

export interface SlicesPartProps {
  readonly session: ViewerSession;
  readonly bounds: Box;
  /** The initial grey window of the slices. */
  readonly grey: cuts.Grey;
}

/** The slices that are drawn in the picture. */
export function SlicesPart(props: SlicesPartProps) {
  const scene = props.session.editor.scene.value;
  if (!scene) return null;
  const slices = cuts.slicesOf(scene);
  return (
    <>
      <h3>{t.settings.cuts.slices}</h3>
      {cuts.sliceNames.map((name) => (
        <SliceControls key={name} {...props} name={name} />
      ))}
      {cuts.showsSlices(slices) ? <SliceColouring {...props} /> : null}
    </>
  );
}

function SliceControls({ session, bounds, grey, name }: SlicesPartProps & { readonly name: cuts.SliceName }) {
  const text = t.settings.cuts;
  const scene = session.editor.scene.value;
  const slice = scene ? cuts.slicesOf(scene)[name] : undefined;
  const axis = cuts.sliceAxes[name];
  const { live, once, rest } = sceneEdits(session.editor);
  return (
    <div data-slice={name}>
      <Switch
        label={text.show(text.slice[name])}
        on={slice?.shown ?? false}
        change={once(`slice ${name}`, (now, shown: boolean) => cuts.setSlice(now, bounds, grey, name, { shown }))}
      />
      {slice?.shown ? (
        <NumberControl
          label={text.position(text.slice[name])}
          unit={t.settings.mm}
          value={slice.position}
          limits={{ low: bounds.low[axis], high: bounds.high[axis] }}
          step={0.5}
          rest={rest}
          change={live(`slice at ${name}`, (now, position) => cuts.setSlice(now, bounds, grey, name, { position }))}
        />
      ) : null}
    </div>
  );
}

/** How all shown slices are coloured, and whether only they are shown. */
function SliceColouring({ session, grey }: SlicesPartProps) {
  const text = t.settings.cuts;
  const scene = session.editor.scene.value;
  if (!scene) return null;
  const slices = cuts.slicesOf(scene);
  const inColour = slices.colouring === SlicesColouring.TRANSFER;
  const { once } = sceneEdits(session.editor);
  const setColouring = once("slice colours", (now, transfer: boolean) => cuts.setColouring(now, grey, transfer));
  return (
    <>
      <Switch
        label={text.alone}
        on={slices.alone}
        change={once("slices alone", (now, alone: boolean) => cuts.setAlone(now, grey, alone))}
      />
      <SelectControl
        label={text.colouring}
        value={inColour ? "transfer" : "grey"}
        options={[
          ["grey", text.grey],
          ["transfer", text.transfer],
        ]}
        change={(chosen) => setColouring(chosen === "transfer")}
      />
      {inColour ? null : <GreyWindow session={session} grey={grey} />}
    </>
  );
}

function GreyWindow({ session, grey }: Pick<SlicesPartProps, "session" | "grey">) {
  const text = t.settings.cuts;
  const scene = session.editor.scene.value;
  if (!scene) return null;
  const slices = cuts.slicesOf(scene);
  const { live, rest } = sceneEdits(session.editor);
  return (
    <>
      <NumberControl
        label={text.level}
        value={slices.windowCentre}
        limits={cuts.windowCentreLimits}
        slide={{ low: -1000, high: 2000 }}
        rest={rest}
        change={live("level", (now, centre: number) => cuts.setWindow(now, grey, { centre }))}
      />
      <NumberControl
        label={text.window}
        value={slices.windowWidth}
        limits={cuts.windowWidthLimits}
        slide={{ low: 1, high: 4000 }}
        logarithmic
        rest={rest}
        change={live("window", (now, width: number) => cuts.setWindow(now, grey, { width }))}
      />
    </>
  );
}
