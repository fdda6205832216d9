import { arrowDirections } from "../../../input/arrow_keys";
import type { Area, Point } from "../../../input/flat";
import { wheelZoom } from "../../../input/gestures";
import { pointerSampleOf } from "../../../input/pointer_sample";
import { preventBrowserGestures } from "../../../input/prevent_browser_gestures";
import { heldSpot, type CurvedSlice, type CurveSpot } from "../../../slices/curve_view";
import type { Slices } from "../../../slices/model";
import { panned, pixelAt, zoomed } from "../../../slices/placing";
import { SliceGestures, type GestureAction } from "../../../slices/slice_gestures";
import { dragged, type Window } from "../../../slices/window";

const zoomStep = 1.12;
/** The angle by which a key turns the slice about the curve. */
const keyDegrees = 5;

/** Applies gestures and keys on the slice along the curve. */
export class CurvePaneController {
  private readonly gestures = new SliceGestures();
  private begun: Window | null = null;

  constructor(
    private readonly slices: Slices,
    private readonly slice: () => CurvedSlice | null,
    private readonly area: () => Area,
    /** The range of values that dragging over the full height of the pane covers. */
    private readonly range: () => number,
  ) {}

  /** Listens to pointers and to the wheel until `signal` is aborted. */
  listen(element: HTMLElement, signal: AbortSignal): void {
    const passive = { signal, passive: true };
    const { pointed } = this.slices.curve;
    element.addEventListener(
      "pointerdown",
      (event) => {
        element.setPointerCapture(event.pointerId);
        this.performAll(this.gestures.down(pointerSampleOf(event, element)));
      },
      passive,
    );
    element.addEventListener(
      "pointermove",
      (event) => {
        const sample = pointerSampleOf(event, element);
        const slice = this.slice();
        if (slice && !sample.touch) pointed.value = this.spotAt(slice, sample);
        this.performAll(this.gestures.move(sample));
      },
      passive,
    );
    const up = (lost: boolean) => (event: PointerEvent) => {
      this.performAll(this.gestures.up(event.pointerId, lost));
      this.begun = null;
    };
    element.addEventListener("pointerup", up(false), passive);
    element.addEventListener("pointercancel", up(true), passive);
    element.addEventListener("pointerleave", () => (pointed.value = null), passive);
    element.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        const at = { x: event.offsetX, y: event.offsetY };
        this.performAll([{ kind: "zoom", factor: wheelZoom(event.deltaY, event.deltaMode, event.ctrlKey), at }]);
      },
      { signal, passive: false },
    );
    preventBrowserGestures(element, signal);
  }

  /** Handles a key and returns whether the pane uses it. */
  key(event: KeyboardEvent): boolean {
    const slice = this.slice();
    const { curve } = this.slices;
    if (event.altKey || event.metaKey || !slice) return false;
    const direction = arrowDirections[event.key];
    if (direction) {
      const [right, down] = direction;
      if (event.ctrlKey) this.pan(slice, { x: 24 * right, y: 24 * down });
      else this.step(slice, right, down, event.shiftKey ? 10 : 1);
      return true;
    }
    if (event.ctrlKey) return false;
    const middle = { x: this.area().width / 2, y: this.area().height / 2 };
    switch (event.key) {
      case "+":
      case "=":
        this.zoom(slice, zoomStep, middle);
        return true;
      case "-":
      case "_":
        this.zoom(slice, 1 / zoomStep, middle);
        return true;
      case ",":
      case ".":
        curve.setAngle(curve.angle.value + (event.key === "," ? -keyDegrees : keyDegrees));
        return true;
      case "Delete":
      case "Backspace":
        curve.undo();
        return true;
      case "r":
      case "R":
        curve.place(null);
        return true;
      default:
        return false;
    }
  }

  private performAll(actions: readonly GestureAction[]): void {
    const slice = this.slice();
    if (slice) for (const action of actions) this.perform(slice, action);
  }

  private perform(slice: CurvedSlice, action: GestureAction): void {
    switch (action.kind) {
      case "begin":
        this.begun = this.slices.window.value;
        break;
      case "drag":
        if (this.slices.tool.value === "window") this.changeWindow(action.from, action.at);
        else this.cross(slice, action.at);
        break;
      case "tap":
      case "cross":
        this.cross(slice, action.at);
        break;
      case "pan":
        this.pan(slice, action.by);
        break;
      case "zoom":
        this.zoom(slice, action.factor, action.at);
        break;
      case "scroll":
        break; // there is only one slice
    }
  }

  private changeWindow(from: Point, at: Point): void {
    const { height } = this.area();
    const begun = this.begun ?? this.slices.window.value;
    this.slices.setWindow(dragged(begun, (at.x - from.x) / height, (at.y - from.y) / height, this.range()));
  }

  private spotAt({ grid }: CurvedSlice, at: Point): CurveSpot {
    return heldSpot(grid, pixelAt(grid, this.slices.curve.placing(grid), this.area(), at));
  }

  private cross(slice: CurvedSlice, at: Point): void {
    this.choose(slice, this.spotAt(slice, at));
  }

  private step(slice: CurvedSlice, right: number, down: number, pixels: number): void {
    const { column, row } = this.slices.curve.cursor(slice);
    this.choose(slice, { column: column + pixels * right, row: row + pixels * down });
  }

  /** Moves the crosshair of the other slices to a pixel. */
  private choose(slice: CurvedSlice, spot: CurveSpot): void {
    const { curve } = this.slices;
    curve.choose(slice, spot);
    const found = curve.placeOf(slice, curve.cursor(slice));
    const axial = this.slices.stacks.value.get("axial");
    if (found && axial) this.slices.pointAt(axial, found.place);
  }

  private pan({ grid }: CurvedSlice, { x, y }: Point): void {
    const { curve } = this.slices;
    curve.place(panned(grid, curve.placing(grid), this.area(), x, y));
  }

  private zoom({ grid }: CurvedSlice, factor: number, at: Point): void {
    const { curve } = this.slices;
    curve.place(zoomed(grid, curve.placing(grid), this.area(), factor, at));
  }
}
