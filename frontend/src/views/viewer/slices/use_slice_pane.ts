import type { RefObject } from "preact";
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Area } from "../../../input/flat";
import type { Collaboration } from "../../../live/collaboration";
import type { VolumeHeader } from "../../../protocol/messages";
import type { Marks } from "../../../marks/marks";
import type { Slices } from "../../../slices/model";
import type { Stack } from "../../../slices/stack";
import { useLatest } from "../../use_latest";
import { SliceCanvas } from "./slice_canvas";
import { SlicePaneController } from "./slice_pane_controller";

export interface SlicePaneProps {
  readonly slices: Slices;
  readonly stack: Stack;
  readonly volume: VolumeHeader;
  /** Whether this is the only pane that is shown. */
  readonly alone: boolean;
  readonly collaboration: Collaboration;
  readonly marks: Marks;
  /** The number of this viewer in the session. */
  readonly number: number;
}

/**
 * Returns the canvas of a pane, its size, and its controller. The slice is drawn after each render,
 * and gestures on the canvas are handled.
 */
export function useSlicePane({ slices, stack, volume, collaboration }: SlicePaneProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [area, setArea] = useState<Area>({ width: 0, height: 0 });
  const drawing = useMemo(() => new SliceCanvas(), []);
  const now = useLatest({ stack, area, volume });
  const controller = useMemo(
    () =>
      new SlicePaneController(
        slices,
        () => now.current.stack,
        () => now.current.area,
        () => Math.max(1, now.current.volume.maximum - now.current.volume.minimum),
        collaboration,
      ),
    [slices, now, collaboration],
  );
  useCanvasEvents(canvas, controller, drawing, setArea);

  const placing = slices.placing(stack);
  const voxels = slices.drawnVoxels(stack);
  const table = slices.table.value;
  const labelTable = slices.labelTable.value;
  const second = slices.second.colours.value;
  const smooth = slices.smooth.value;
  useLayoutEffect(() => {
    if (!canvas.current || area.width === 0) return;
    drawing.draw(canvas.current, { stack, voxels, table, labelTable, second, smooth, placing, area });
  });
  return { canvas, controller, area };
}

function useCanvasEvents(
  canvas: RefObject<HTMLCanvasElement | null>,
  controller: SlicePaneController,
  drawing: SliceCanvas,
  setArea: (area: Area) => void,
): void {
  useEffect(() => {
    const element = canvas.current;
    if (!element) return;
    const leaving = new AbortController();
    const measure = () => setArea({ width: element.clientWidth, height: element.clientHeight });
    controller.listen(element, leaving.signal);
    const observer = new ResizeObserver(measure);
    observer.observe(element);
    element.addEventListener(
      "contextrestored",
      () => {
        drawing.forget();
        measure(); // a new area makes the pane draw again
      },
      { signal: leaving.signal },
    );
    return () => {
      leaving.abort();
      observer.disconnect();
    };
  }, [canvas, controller, drawing, setArea]);
}
