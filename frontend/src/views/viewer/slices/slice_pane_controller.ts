import type { Area, Point } from "../../../input/flat";
import { pixelSize, placeOf, spotOf, type Stack } from "../../../slices/stack";
import { isWhole, measureKinds, type MeasureKind } from "../../../slices/measure";
import type { Slices } from "../../../slices/model";
import { SliceGestures, Wheel, type GestureAction } from "../../../slices/slice_gestures";
import { panned, perMm, pixelAt, pointOf, zoomed } from "../../../slices/placing";
import { dragged, type Window } from "../../../slices/window";
import { wheelZoom } from "../../../input/gestures";
import { pointerSampleOf, type PointerSample } from "../../../input/pointer_sample";
import { arrowDirections } from "../../../input/arrow_keys";
import { preventBrowserGestures } from "../../../input/prevent_browser_gestures";
import { attachPointing } from "../../../input/pointing";
import type { Collaboration } from "../../../live/collaboration";
import type { Vec3 } from "../../../input/vec3";

const zoomStep = 1.12;
/** The angle by which a key turns the planes. */
const keyDegrees = 1;
/** A drag this close to the crosshair has no reliable direction. */
const leastTurnPx = 8;
/**
 * The distance in CSS pixels from which a pointer grabs a handle. A finger is less precise than a
 * mouse.
 */
const reach = { mouse: 10, finger: 22 } as const;

/** Applies the gestures and keys on one slice pane to the state of all panes. */
export class SlicePaneController {
  private readonly gestures = new SliceGestures();
  private readonly wheel = new Wheel();
  private begun: Window | null = null;
  private byFinger = false;

  constructor(
    private readonly slices: Slices,
    private readonly stack: () => Stack,
    private readonly area: () => Area,
    /** The range of values that dragging over the full height of the pane covers. */
    private readonly range: () => number,
    /** Shows this viewer's pointer to the other participants. */
    private readonly pointer: Pick<Collaboration, "points" | "point">,
  ) {}

  /** Listens to pointers and to the wheel until `signal` is aborted. */
  listen(element: HTMLElement, signal: AbortSignal): void {
    const passive = { signal, passive: true };
    const pointing = {
      isSeen: () => this.pointer.points.value,
      point: (at: Point | null) => this.pointer.point(at && { plane: this.stack().plane, place: this.placeAt(at) }),
    };
    attachPointing(element, pointing, signal);
    element.addEventListener(
      "pointerdown",
      (event) => {
        element.setPointerCapture(event.pointerId);
        const sample = pointerSampleOf(event, element);
        this.byFinger = sample.touch;
        this.performAll(this.gestures.down(sample));
      },
      passive,
    );
    element.addEventListener("pointermove", (event) => this.pointerMoved(pointerSampleOf(event, element)), passive);
    const up = (lost: boolean) => (event: PointerEvent) => {
      this.performAll(this.gestures.up(event.pointerId, lost));
      this.begun = null;
      this.slices.held.value = null;
      this.slices.curve.held.value = null;
    };
    element.addEventListener("pointerup", up(false), passive);
    element.addEventListener("pointercancel", up(true), passive);
    element.addEventListener("pointerleave", (event) => this.left(event), passive);
    element.addEventListener("dblclick", () => this.doubleClicked(), passive);
    element.addEventListener("wheel", (event) => this.wheelTurned(event), { signal, passive: false });
    preventBrowserGestures(element, signal);
  }

  /** Handles a key and returns whether the pane uses it. */
  key(event: KeyboardEvent): boolean {
    const stack = this.stack();
    const slices = this.slices;
    if (event.altKey || event.metaKey || slices.following.value) return false;
    const direction = arrowDirections[event.key];
    if (direction) {
      const [right, down] = direction;
      if (event.shiftKey) this.step(right, down);
      else if (event.ctrlKey) this.pan({ x: 24 * right, y: 24 * down });
      else slices.scroll(stack, right + down);
      return true;
    }
    if (event.ctrlKey) return false;
    const middle = { x: this.area().width / 2, y: this.area().height / 2 };
    switch (event.key) {
      case "PageDown":
      case "PageUp":
        slices.scroll(stack, event.key === "PageDown" ? 10 : -10);
        return true;
      case "Home":
        slices.goTo(stack, 0);
        return true;
      case "End":
        slices.goTo(stack, stack.slices - 1);
        return true;
      case "+":
      case "=":
        this.zoom(zoomStep, middle);
        return true;
      case "-":
      case "_":
        this.zoom(1 / zoomStep, middle);
        return true;
      case ",":
      case ".":
        slices.turn(stack.plane, event.key === "," ? -keyDegrees : keyDegrees);
        return true;
      case "Enter":
        this.setOrHold();
        return true;
      case "Delete":
      case "Backspace":
        if (this.drawsCurve()) slices.curve.undo();
        else slices.removeLastMeasure();
        return true;
      case "r":
      case "R":
        slices.reset();
        return true;
      default:
        return false;
    }
  }

  /** A finger leaves whenever it is lifted, and the facts of what it pressed stay. */
  private left({ pointerType }: PointerEvent): void {
    if (pointerType !== "touch") this.slices.pointed.value = null;
  }

  private pointerMoved(sample: PointerSample): void {
    if (!sample.touch) this.slices.pointed.value = { plane: this.stack().plane, place: this.placeAt(sample) };
    this.performAll(this.gestures.move(sample));
  }

  private doubleClicked(): void {
    // Each click of a measuring tool or of the curve sets a point.
    if (this.slices.following.value || this.measureKind() || this.drawsCurve()) return;
    this.slices.maximise(this.stack().plane);
  }

  private wheelTurned(event: WheelEvent): void {
    event.preventDefault();
    if (event.ctrlKey) {
      const at = { x: event.offsetX, y: event.offsetY };
      this.performAll([{ kind: "zoom", factor: wheelZoom(event.deltaY, event.deltaMode, true), at }]);
      return;
    }
    const slices = this.wheel.slices(event.deltaY, event.deltaMode);
    if (slices !== 0) this.performAll([{ kind: "scroll", slices }]);
  }

  private performAll(actions: readonly GestureAction[]): void {
    if (this.slices.following.value) return;
    for (const action of actions) this.perform(action);
  }

  private perform(action: GestureAction): void {
    const slices = this.slices;
    switch (action.kind) {
      case "begin":
        this.begun = slices.window.value;
        if (this.measureKind()) this.beginMeasure(this.placeAt(action.at));
        if (this.drawsCurve()) this.beginCurve(this.placeAt(action.at));
        break;
      case "drag":
        this.drag(action.from, action.at, action.by);
        break;
      case "tap":
        if (slices.tool.value === "crosshair") this.cross(action.at);
        else this.setPoint(this.placeAt(action.at));
        if (!this.measureKind() && !this.drawsCurve()) this.press(action.at);
        break;
      case "cross":
        this.cross(action.at);
        break;
      case "pan":
        this.pan(action.by);
        break;
      case "zoom":
        this.zoom(action.factor, action.at);
        break;
      case "scroll":
        slices.scroll(this.stack(), action.slices);
        break;
    }
  }

  private drag(from: Point, at: Point, by: Point): void {
    const slices = this.slices;
    switch (slices.tool.value) {
      case "window": {
        const { height } = this.area();
        const begun = this.begun ?? slices.window.value;
        slices.setWindow(dragged(begun, (at.x - from.x) / height, (at.y - from.y) / height, this.range()));
        break;
      }
      case "crosshair":
        this.cross(at);
        break;
      case "tilt":
        this.turn({ x: at.x - by.x, y: at.y - by.y }, at);
        break;
      case "curve":
        slices.curve.moveHeld(this.placeAt(at));
        break;
      default:
        if (slices.held.value) slices.moveHeld(this.stack(), this.placeAt(at));
        else slices.moveLastPoint(this.stack(), this.placeAt(at));
    }
  }

  /** Returns the kind that the tool measures, or null for another tool. */
  private measureKind(): MeasureKind | null {
    return measureKinds.find((kind) => kind === this.slices.tool.value) ?? null;
  }

  private drawsCurve(): boolean {
    return this.slices.tool.value === "curve";
  }

  /** Returns the distance in mm from which the pointer grabs something. */
  private reach(): number {
    const stack = this.stack();
    return (this.byFinger ? reach.finger : reach.mouse) / perMm(stack, this.slices.placing(stack), this.area());
  }

  /** Grabs a point of the curve, or adds one that follows the pointer. */
  private beginCurve(place: Vec3): void {
    const { curve } = this.slices;
    const stack = this.stack();
    if (!curve.hold(stack, this.slices.index(stack), place, this.reach())) curve.add(place);
  }

  /** Grabs a handle, or starts a measurement whose end follows the pointer. */
  private beginMeasure(place: Vec3): void {
    if (this.slices.hold(this.stack(), place, this.reach())) return;
    this.setPoint(place);
    const last = this.slices.measures.value.at(-1);
    if (last && !isWhole(last) && last.points.length === 1) this.setPoint(place);
  }

  /**
   * Handles Enter, which sets a point at the crosshair, or grabs a handle there. Enter again
   * releases the handle.
   */
  private setOrHold(): void {
    const { held, crosshair } = this.slices;
    const stack = this.stack();
    const { width, height } = pixelSize(stack);
    if (held.value) held.value = null;
    else if (!this.measureKind() || !this.slices.hold(stack, crosshair.value, 0.75 * Math.hypot(width, height)))
      this.setPoint(crosshair.value);
  }

  private step(right: number, down: number): void {
    const stack = this.stack();
    this.slices.step(stack, right, down);
    this.slices.moveHeld(stack, this.slices.crosshair.value);
  }

  private setPoint(place: Vec3): void {
    if (this.drawsCurve()) this.slices.curve.add(place);
    const kind = this.measureKind();
    if (kind) this.slices.setPoint(this.stack(), kind, place);
  }

  /** Turns the other planes with the pointer about the crosshair. */
  private turn(from: Point, to: Point): void {
    const stack = this.stack();
    const middle = pointOf(stack, this.slices.placing(stack), this.area(), spotOf(stack, this.slices.crosshair.value));
    const [before, after] = [from, to].map(({ x, y }) => ({ x: x - middle.x, y: y - middle.y }));
    if (!before || !after || Math.min(Math.hypot(before.x, before.y), Math.hypot(after.x, after.y)) < leastTurnPx)
      return;
    const across = before.x * after.y - before.y * after.x;
    const along = before.x * after.x + before.y * after.y;
    this.slices.turn(stack.plane, (180 / Math.PI) * Math.atan2(across, along));
  }

  /** Shows the facts of the pressed place, and chooses its label in the list. */
  private press(at: Point): void {
    const place = this.placeAt(at);
    this.slices.pointed.value = { plane: this.stack().plane, place };
    this.slices.chosenLabel.value = this.slices.labelAt(this.stack(), place)?.number ?? null;
  }

  private cross(at: Point): void {
    this.slices.pointAt(this.stack(), this.placeAt(at));
  }

  private pan({ x, y }: Point): void {
    const stack = this.stack();
    this.slices.place(stack, panned(stack, this.slices.placing(stack), this.area(), x, y));
  }

  private zoom(factor: number, at: Point): void {
    const stack = this.stack();
    this.slices.place(stack, zoomed(stack, this.slices.placing(stack), this.area(), factor, at));
  }

  /** Returns the point in the middle of the slice's thickness. */
  private placeAt(at: Point): Vec3 {
    const stack = this.stack();
    return placeOf(stack, {
      ...pixelAt(stack, this.slices.placing(stack), this.area(), at),
      slice: this.slices.index(stack),
    });
  }
}
