import type { Area } from "../../../input/flat";
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import { blank, type Slices } from "../../../slices/model";
import { edges_of, is_inside, said_place, type Plane, type Stack } from "../../../slices/stack";
import type { Vec3 } from "../../../input/vec3";
import { Modality, type VolumeHeader } from "../../../protocol/messages";
import { t } from "../../../texts";
import { Icon } from "../../icons";
import { Marks } from "./marks";
import { PaneDeeds } from "./pane_deeds";
import { SliceCanvas } from "./slice_canvas";

export interface SlicePaneProps {
  readonly slices: Slices;
  readonly stack: Stack;
  readonly volume: VolumeHeader;
  /** The only one that is shown. */
  readonly alone: boolean;
}

/** One slice: drawn from its values, and all that hands do with it. */
export function SlicePane({ slices, stack, volume, alone }: SlicePaneProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [area, set_area] = useState<Area>({ width: 0, height: 0 });
  const [by_key, set_by_key] = useState(false);
  const drawing = useMemo(() => new SliceCanvas(), []);
  const now = useRef({ stack, area, volume });
  now.current = { stack, area, volume };
  const deeds = useMemo(
    () => new PaneDeeds(slices, () => now.current.stack, () => now.current.area, () => Math.max(1, now.current.volume.maximum - now.current.volume.minimum)),
    [slices],
  );

  useEffect(() => {
    const element = canvas.current;
    if (!element) return;
    const leaving = new AbortController();
    deeds.listen(element, leaving.signal);
    const observer = new ResizeObserver(() => set_area({ width: element.clientWidth, height: element.clientHeight }));
    observer.observe(element);
    element.addEventListener("contextrestored", () => {
      drawing.forget();
      set_area({ width: element.clientWidth, height: element.clientHeight }); // drawn again
    }, { signal: leaving.signal });
    return () => {
      leaving.abort();
      observer.disconnect();
    };
  }, [deeds, drawing]);

  const index = slices.index(stack);
  const placing = slices.placing(stack);
  const values = slices.values(stack);
  const table = slices.table.value;
  useLayoutEffect(() => {
    if (canvas.current && area.width > 0) drawing.draw(canvas.current, stack, values, table, placing, area);
  });

  const name = t.slices.view[stack.plane];
  const title = t.slices.title(name, index + 1, stack.slices);
  const edges = edges_of(stack);
  const pointed = slices.pointed.value;
  const place = pointed?.plane === stack.plane ? pointed.place : slices.crosshair.value;
  const value = said_value(slices, stack, volume, place);
  const where = t.slices.place(said_place(place));
  const measures = slices.measures.value.filter((measure) => measure.plane === stack.plane && measure.slice === index);
  return (
    <section class="slice-pane" data-plane={stack.plane} aria-label={name}>
      <canvas ref={canvas} tabIndex={0} role="application" aria-label={t.slices.canvas(name)} data-index={index} data-came={values !== null}
        onKeyDown={(event) => {
          if (!deeds.key(event)) return;
          event.preventDefault();
          set_by_key(true);
        }}
        onBlur={() => set_by_key(false)} />
      <Marks stack={stack} placing={placing} area={area} crosshair={slices.crosshair.value} measures={measures} />
      {(["left", "right", "top", "bottom"] as const).map((edge) => <span key={edge} class={`slice-letter slice-letter-${edge}`}>{edges[edge]}</span>)}
      <h2 class="slice-title">{title}</h2>
      <p class="slice-facts">
        <b class="slice-value">{value}</b> <span class="slice-place">{where}</span>
      </p>
      <p class="visually-hidden" role="status">{by_key ? t.slices.said(title, value, where) : ""}</p>
      <button type="button" class="icon-button slice-maximise" aria-label={alone ? t.slices.restore : t.slices.maximise(name)} title={alone ? t.slices.restore : t.slices.maximise(name)}
        onClick={() => slices.maximise(stack.plane)}>
        <Icon name={alone ? "four" : "fullscreen"} />
      </button>
      <input class="slice-slider" type="range" min={0} max={stack.slices - 1} step={1} value={index} aria-label={t.slices.slider(name)}
        aria-valuetext={t.slices.number(index + 1, stack.slices)} onInput={(event) => slices.go_to(stack, event.currentTarget.valueAsNumber)} />
    </section>
  );
}

function said_value(slices: Slices, stack: Stack, volume: VolumeHeader, place: Vec3): string {
  if (!is_inside(volume, place)) return t.slices.nothing;
  const value = slices.value_at(stack, place);
  if (value === null) return "…";
  if (value === blank && slices.access.value === "clipped") return t.slices.cut_away;
  return volume.modality === Modality.CT ? t.slices.hu(value) : t.slices.value(value);
}

/** In the order in which they stand beside each other. */
export const pane_order: readonly Plane[] = ["axial", "sagittal", "coronal"];
