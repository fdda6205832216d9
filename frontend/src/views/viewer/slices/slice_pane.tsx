import { useMemo, useState } from "preact/hooks";
import type { Vec3 } from "../../../input/vec3";
import { Modality } from "../../../protocol/messages";
import type { Slices } from "../../../slices/model";
import { tiltDegrees, unitAxes } from "../../../slices/oblique";
import {
  edgesOf,
  inSlice,
  isInside,
  pixelOf,
  placeOf,
  placeParts,
  type Plane,
  type Stack,
} from "../../../slices/stack";
import { t } from "../../../texts";
import { SliceMarks } from "../../marks/slice_marks";
import { IconButton } from "../../icon_button";
import { perMm } from "../../../slices/placing";
import { nameOf } from "../../labels/label_name";
import { isInSlice } from "../../../slices/measure";
import { CurveLine } from "./curve_line";
import { Marks } from "./marks";
import { ScaleBar } from "./scale_bar";
import { SlicePointers } from "./slice_pointers";
import { measureLines, type MeasuredSlice } from "./measure_text";
import { valueText, withSecond } from "./value_text";
import { useSlicePane, type SlicePaneProps } from "./use_slice_pane";

/** One slice with its marks, its facts and its slider. */
export function SlicePane(props: SlicePaneProps) {
  const { slices, stack, alone, collaboration } = props;
  const { canvas, controller, area } = useSlicePane(props);
  const [byKey, setByKey] = useState(false);
  const index = slices.index(stack);
  const name = t.slices.view[stack.plane];
  const slice = useMeasuredSlice(props);
  return (
    <section class="slice-pane" data-plane={stack.plane} aria-label={name}>
      <canvas
        ref={canvas}
        tabIndex={0}
        role="application"
        aria-label={t.slices.canvas(name)}
        data-index={index}
        data-came={slices.values(stack) !== null}
        data-oblique={stack.oblique ? "" : undefined}
        onKeyDown={(event) => {
          if (!controller.key(event)) return;
          event.preventDefault();
          setByKey(true);
        }}
        onBlur={() => setByKey(false)}
      />
      <Marks
        slice={slice}
        placing={slices.placing(stack)}
        area={area}
        crosshair={slices.crosshair.value}
        measures={slices.measures.value}
        index={index}
        held={slices.held.value}
        others={[...slices.stacks.value.values()].filter(({ plane }) => plane !== stack.plane)}
        turning={slices.tool.value === "tilt" && !slices.following.value}
      />
      <CurveLine slices={slices} stack={stack} index={index} area={area} />
      <SliceMarks
        marks={props.marks}
        number={props.number}
        stack={stack}
        index={index}
        placing={slices.placing(stack)}
        area={area}
      />
      <SlicePointers
        collaboration={collaboration}
        stack={stack}
        index={index}
        placing={slices.placing(stack)}
        area={area}
      />
      <SliceLabels {...props} slice={slice} byKey={byKey} />
      <ScaleBar pixelsPerMm={perMm(stack, slices.placing(stack), area)} area={area} />
      <PaneControls slices={slices} stack={stack} alone={alone} index={index} name={name} />
    </section>
  );
}

interface PaneControlsProps extends Pick<SlicePaneProps, "slices" | "stack" | "alone"> {
  readonly index: number;
  readonly name: string;
}

/** Shows this slice alone, and scrolls. A follower sees where the presenter is. */
function PaneControls({ slices, stack, alone, index, name }: PaneControlsProps) {
  const following = slices.following.value;
  return (
    <>
      {following ? null : (
        <IconButton
          class="slice-maximise"
          icon={alone ? "four" : "fullscreen"}
          label={alone ? t.slices.restore : t.slices.maximise(name)}
          onClick={() => slices.maximise(stack.plane)}
        />
      )}
      <input
        class="slice-slider"
        type="range"
        min={0}
        max={stack.slices - 1}
        step={1}
        disabled={following}
        value={index}
        aria-label={t.slices.slider(name)}
        aria-valuetext={t.slices.number(index + 1, stack.slices)}
        onInput={(event) => slices.goTo(stack, event.currentTarget.valueAsNumber)}
      />
    </>
  );
}

/**
 * Returns the shown slice for measurements: the same object while nothing that they depend on
 * changes.
 */
function useMeasuredSlice({ slices, stack, volume }: SlicePaneProps): MeasuredSlice {
  const values = slices.values(stack);
  const clipped = slices.access.value !== "whole";
  return useMemo(
    () => ({
      stack,
      pixels: values && { values, clipped, isInside: (place: Vec3) => isInside(volume, place) },
      hounsfield: volume.modality === Modality.CT,
    }),
    [stack, values, clipped, volume],
  );
}

interface SliceLabelsProps extends SlicePaneProps {
  readonly slice: MeasuredSlice;
  readonly byKey: boolean;
}

/**
 * The letters at the edges, and the title, value and position. A screen reader announces them while keys move the
 * slice.
 */
function SliceLabels({ slices, stack, volume, slice, byKey }: SliceLabelsProps) {
  const edges = edgesOf(stack);
  const title = titleOf(slices, stack);
  const pointed = slices.pointed.value;
  // The slice may have been scrolled under the pointer.
  const exact =
    pointed?.plane === stack.plane ? inSlice(stack, pointed.place, slices.index(stack)) : slices.crosshair.value;
  // A value between the stored ones is that of the middle of a pixel.
  const place = stack.oblique ? placeOf(stack, pixelOf(stack, exact)) : exact;
  const second = slices.secondAt(stack, place);
  const first = valueText(slices, volume, place, slices.valueAt(stack, place), Boolean(stack.oblique));
  const value = withSecond(first, second);
  const where = t.slices.place(placeParts(place));
  const label = isInside(volume, place) ? slices.labelAt(stack, place) : null;
  const name = label ? [nameOf(label)] : [];
  const said = () => [t.slices.said(title, value, where), ...name, ...measuresSaid(slices, slice)].join(", ");
  return (
    <>
      {(["left", "right", "top", "bottom"] as const).map((edge) => (
        <span key={edge} class={`slice-letter slice-letter-${edge}`}>
          {edges[edge]}
        </span>
      ))}
      <h2 class="slice-title">{title}</h2>
      <p class="slice-facts">
        {label ? <span class="slice-label">{nameOf(label)}</span> : null}
        <b class="slice-value">{value}</b> <span class="slice-place">{where}</span>
      </p>
      <p class="visually-hidden" role="status">
        {byKey ? said() : ""}
      </p>
    </>
  );
}

/** Returns the plane, its tilt and its slab, and the number of the slice. */
function titleOf(slices: Slices, stack: Stack): string {
  const title = t.slices.title(t.slices.view[stack.plane], slices.index(stack) + 1, stack.slices);
  const straight = slices.straight.value.get(stack.plane);
  const { mm, projection } = slices.slab.value;
  const degrees = straight ? tiltDegrees(unitAxes(stack), unitAxes(straight)) : 0;
  return [
    title,
    ...(degrees >= 0.05 ? [t.slices.tilted(degrees)] : []),
    ...(mm > 0 ? [t.slices.thick(mm, t.slices.projections[projection])] : []),
  ].join(", ");
}

/** Returns the text of the newest measurement in the slice, for users who do not see it. */
function measuresSaid(slices: Slices, slice: MeasuredSlice): readonly string[] {
  const index = slices.index(slice.stack);
  const newest = slices.measures.value.findLast((measure) => isInSlice(measure, slice.stack, index));
  return [...(newest ? measureLines(newest, slice) : []), ...(slices.held.value ? [t.slices.held] : [])];
}

/** The order of the panes. */
export const paneOrder: readonly Plane[] = ["axial", "sagittal", "coronal"];
