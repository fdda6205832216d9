import { useState } from "preact/hooks";
import type { Vec3 } from "../../../input/vec3";
import { Modality, type VolumeHeader } from "../../../protocol/messages";
import { blank, type Slices } from "../../../slices/model";
import { edgesOf, isInside, saidPlace, type Plane, type Stack } from "../../../slices/stack";
import { t } from "../../../texts";
import { IconButton } from "../../icon_button";
import { Marks } from "./marks";
import { useSlicePane, type SlicePaneProps } from "./use_slice_pane";

/** One slice with its marks, its facts and its slider. */
export function SlicePane(props: SlicePaneProps) {
  const { slices, stack, alone } = props;
  const { canvas, controller, area } = useSlicePane(props);
  const [byKey, setByKey] = useState(false);
  const index = slices.index(stack);
  const name = t.slices.view[stack.plane];
  const measures = slices.measures.value.filter((measure) => measure.plane === stack.plane && measure.slice === index);
  return (
    <section class="slice-pane" data-plane={stack.plane} aria-label={name}>
      <canvas
        ref={canvas}
        tabIndex={0}
        role="application"
        aria-label={t.slices.canvas(name)}
        data-index={index}
        data-came={slices.values(stack) !== null}
        onKeyDown={(event) => {
          if (!controller.key(event)) return;
          event.preventDefault();
          setByKey(true);
        }}
        onBlur={() => setByKey(false)}
      />
      <Marks
        stack={stack}
        placing={slices.placing(stack)}
        area={area}
        crosshair={slices.crosshair.value}
        measures={measures}
      />
      <SliceLabels {...props} byKey={byKey} />
      <IconButton
        class="slice-maximise"
        icon={alone ? "four" : "fullscreen"}
        label={alone ? t.slices.restore : t.slices.maximise(name)}
        onClick={() => slices.maximise(stack.plane)}
      />
      <input
        class="slice-slider"
        type="range"
        min={0}
        max={stack.slices - 1}
        step={1}
        value={index}
        aria-label={t.slices.slider(name)}
        aria-valuetext={t.slices.number(index + 1, stack.slices)}
        onInput={(event) => slices.goTo(stack, event.currentTarget.valueAsNumber)}
      />
    </section>
  );
}

/**
 * The letters at the edges, and the title, value and position. A screen reader announces them while keys move the
 * slice.
 */
function SliceLabels({ slices, stack, volume, byKey }: SlicePaneProps & { readonly byKey: boolean }) {
  const edges = edgesOf(stack);
  const title = t.slices.title(t.slices.view[stack.plane], slices.index(stack) + 1, stack.slices);
  const pointed = slices.pointed.value;
  const place = pointed?.plane === stack.plane ? pointed.place : slices.crosshair.value;
  const value = valueText(slices, stack, volume, place);
  const where = t.slices.place(saidPlace(place));
  return (
    <>
      {(["left", "right", "top", "bottom"] as const).map((edge) => (
        <span key={edge} class={`slice-letter slice-letter-${edge}`}>
          {edges[edge]}
        </span>
      ))}
      <h2 class="slice-title">{title}</h2>
      <p class="slice-facts">
        <b class="slice-value">{value}</b> <span class="slice-place">{where}</span>
      </p>
      <p class="visually-hidden" role="status">
        {byKey ? t.slices.said(title, value, where) : ""}
      </p>
    </>
  );
}

function valueText(slices: Slices, stack: Stack, volume: VolumeHeader, place: Vec3): string {
  if (!isInside(volume, place)) return t.slices.nothing;
  const value = slices.valueAt(stack, place);
  if (value === null) return "…";
  if (value === blank && slices.access.value === "clipped") return t.slices.cutAway;
  return volume.modality === Modality.CT ? t.slices.hu(value) : t.slices.value(value);
}

/** The order of the panes. */
export const paneOrder: readonly Plane[] = ["axial", "sagittal", "coronal"];
