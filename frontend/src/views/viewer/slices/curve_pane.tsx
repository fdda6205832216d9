import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Area } from "../../../input/flat";
import { scale } from "../../../input/vec3";
import type { VolumeHeader } from "../../../protocol/messages";
import { angleLimits, type CurvedSlice, type CurveSpot } from "../../../slices/curve_view";
import { measureKinds } from "../../../slices/measure";
import type { Slices } from "../../../slices/model";
import { perMm, pointOf } from "../../../slices/placing";
import { isInside, placeParts, sidesOf } from "../../../slices/stack";
import { t } from "../../../texts";
import { nameOf } from "../../labels/label_name";
import { useLatest } from "../../use_latest";
import { CurvePaneController } from "./curve_pane_controller";
import { ScaleBar } from "./scale_bar";
import { SliceCanvas } from "./slice_canvas";
import { valueText, withSecond } from "./value_text";

interface CurvePaneProps {
  readonly slices: Slices;
  readonly volume: VolumeHeader;
}

/** The slice along the curve, or what to do until there is one. */
export function CurvePane({ slices, volume }: CurvePaneProps) {
  const { canvas, controller, area } = useCurveCanvas(slices, volume);
  const [byKey, setByKey] = useState(false);
  const { curve } = slices;
  const slice = curve.slice.value;
  return (
    <section class="slice-pane curve-pane" aria-label={t.slices.curve.name}>
      <canvas
        ref={canvas}
        tabIndex={slice ? 0 : -1}
        role="application"
        aria-label={t.slices.curve.canvas}
        data-came={slice !== null && slices.curveVoxels(slice) !== null}
        data-columns={slice?.grid.columns}
        data-rows={slice?.grid.rows}
        data-pixel={slice?.pixel}
        onKeyDown={(event) => {
          if (!controller.key(event)) return;
          event.preventDefault();
          setByKey(true);
        }}
        onBlur={() => setByKey(false)}
      />
      {slice ? (
        <>
          <CurveMarks slices={slices} slice={slice} area={area} />
          <CurveFacts slices={slices} volume={volume} slice={slice} byKey={byKey} />
          <ScaleBar pixelsPerMm={perMm(slice.grid, curve.placing(slice.grid), area)} area={area} />
          <AngleSlider slices={slices} />
        </>
      ) : (
        <p class="curve-hint" role="status">
          {t.slices.curve.hint}
        </p>
      )}
      {slice && measureKinds.some((kind) => kind === slices.tool.value) ? (
        <p class="curve-hint curve-note">{t.slices.curve.noMeasures}</p>
      ) : null}
      {curve.full ? <p class="curve-hint curve-note">{t.slices.curve.full}</p> : null}
    </section>
  );
}

/** Returns the canvas of the pane, which is drawn after each render, its size, and its controller. */
function useCurveCanvas(slices: Slices, volume: VolumeHeader) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [area, setArea] = useState<Area>({ width: 0, height: 0 });
  const drawing = useMemo(() => new SliceCanvas(), []);
  const slice = slices.curve.slice.value;
  const now = useLatest({ slice, area, volume });
  const controller = useMemo(
    () =>
      new CurvePaneController(
        slices,
        () => now.current.slice,
        () => now.current.area,
        () => Math.max(1, now.current.volume.maximum - now.current.volume.minimum),
      ),
    [slices, now],
  );
  useEffect(() => {
    const element = canvas.current;
    if (!element) return;
    const leaving = new AbortController();
    const measure = () => setArea({ width: element.clientWidth, height: element.clientHeight });
    controller.listen(element, leaving.signal);
    const observer = new ResizeObserver(measure);
    observer.observe(element);
    const restored = () => {
      drawing.forget();
      measure(); // a new area makes the pane draw again
    };
    element.addEventListener("contextrestored", restored, { signal: leaving.signal });
    return () => {
      leaving.abort();
      observer.disconnect();
    };
  }, [controller, drawing]);
  const look = { table: slices.table.value, labelTable: slices.labelTable.value, smooth: slices.smooth.value };
  const second = slices.second.colours.value;
  const grid = slice?.grid ?? noGrid;
  const voxels = slice && slices.curveVoxels(slice, true);
  const placing = slices.curve.placing(grid);
  useLayoutEffect(() => {
    if (canvas.current && area.width > 0)
      drawing.draw(canvas.current, { stack: grid, voxels, ...look, second, placing, area });
  });
  return { canvas, controller, area };
}

const origin = { x: 0, y: 0, z: 0 };
const one = { x: 1, y: 1, z: 1 };
const noGrid = { columns: 1, rows: 1, slices: 1, first: origin, right: one, down: one, next: one };

interface InSliceProps {
  readonly slices: Slices;
  readonly slice: CurvedSlice;
}

/** The pressed pixel, the middle line, and the places of the points. */
function CurveMarks({ slices, slice, area }: InSliceProps & { readonly area: Area }) {
  const { curve } = slices;
  const { grid, pixel } = slice;
  const onView = (spot: CurveSpot) => pointOf(grid, curve.placing(grid), area, spot);
  const row = (grid.rows - 1) / 2;
  const path = curve.path.value;
  const [from, to] = [onView({ column: -0.5, row }), onView({ column: grid.columns - 0.5, row })];
  const { x, y } = onView(curve.cursor(slice));
  return (
    <svg class="slice-marks slice-curve" aria-hidden="true" width={area.width} height={area.height}>
      <path class="slice-curve-far" d={`M${from.x} ${from.y}L${to.x} ${to.y}`} />
      {slice.points.map((point, i) => {
        const at = onView({ column: (path?.nearest(point).arc ?? 0) / pixel, row });
        return <circle key={i} cx={at.x} cy={at.y} r={3} />;
      })}
      <g class="slice-cross">
        <path d={`M${x} 0V${y - 9}M${x} ${y + 9}V${area.height}M${x - 14} ${y}H${x - 5}M${x + 5} ${y}H${x + 14}`} />
      </g>
    </svg>
  );
}

interface CurveFactsProps extends InSliceProps {
  readonly volume: VolumeHeader;
  readonly byKey: boolean;
}

/** The title, and the value and the position under the pointer. A screen reader announces them while keys move. */
function CurveFacts({ slices, slice, volume, byKey }: CurveFactsProps) {
  const { curve } = slices;
  const { grid, pixel } = slice;
  const spot = curve.pointed.value ?? curve.cursor(slice);
  const found = curve.placeOf(slice, spot);
  if (!found) return null;
  const offset = spot.row * grid.columns + spot.column;
  const voxels = slices.curveVoxels(slice);
  const first = valueText(slices, volume, found.place, voxels?.values[offset] ?? null, true);
  const value = withSecond(first, slices.second.valueOf(voxels?.second?.[offset]));
  const label = isInside(volume, found.place) ? slices.labelOf(voxels?.labels?.[offset]) : null;
  const along = t.slices.curve.position(spot.column * pixel, (spot.row - (grid.rows - 1) / 2) * pixel);
  const where = t.slices.place(placeParts(found.place));
  const title = titleOf(slices);
  return (
    <>
      <span class="slice-letter slice-letter-top">{sidesOf(scale(found.down, -1))}</span>
      <span class="slice-letter slice-letter-bottom">{sidesOf(found.down)}</span>
      <h2 class="slice-title">{title}</h2>
      <p class="slice-facts">
        {label ? <span class="slice-label">{nameOf(label)}</span> : null}
        <b class="slice-value">{value}</b> <span class="curve-position">{along}</span>{" "}
        <span class="slice-place">{where}</span>
      </p>
      <p class="visually-hidden" role="status">
        {byKey ? [title, value, along, ...(label ? [nameOf(label)] : [])].join(", ") : ""}
      </p>
    </>
  );
}

function titleOf({ curve, slab }: Slices): string {
  const { mm, projection } = slab.value;
  return [
    t.slices.curve.title(curve.path.value?.length ?? 0),
    ...(mm > 0 ? [t.slices.thick(mm, t.slices.projections[projection])] : []),
  ].join(", ");
}

/** Turns the slice about the curve. */
function AngleSlider({ slices: { curve } }: { readonly slices: Slices }) {
  const degrees = Math.round(curve.angle.value);
  return (
    <label class="curve-angle" title={t.slices.curve.angleHelp}>
      <span>{t.slices.curve.angle(degrees)}</span>
      <input
        type="range"
        min={angleLimits.low}
        max={angleLimits.high}
        step={1}
        value={degrees}
        aria-label={t.slices.curve.angleName}
        aria-valuetext={t.slices.curve.angle(degrees)}
        onInput={(event) => curve.setAngle(event.currentTarget.valueAsNumber)}
      />
    </label>
  );
}
