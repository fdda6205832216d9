import type { Area, Point } from "../../../input/flat";
import { place_of, type Stack } from "../../../slices/stack";
import { with_last_point, with_point, without_last } from "../../../slices/measure";
import type { Slices } from "../../../slices/model";
import { SliceHands, Wheel, type Deed, type Touching } from "../../../slices/hands";
import { panned, pixel_at, zoomed } from "../../../slices/placing";
import { dragged, type Window } from "../../../slices/window";
import { wheel_zoom } from "../../../input/gestures";
import { no_flick } from "../../../input/no_flick";
import type { Vec3 } from "../../../input/vec3";

const zoom_step = 1.12;

/** What hands and keys on one slice do to all of them. */
export class PaneDeeds {
  private readonly hands_ = new SliceHands();
  private readonly wheel_ = new Wheel();
  private begun_: Window | null = null;

  constructor(
    private readonly slices_: Slices,
    private readonly stack_: () => Stack,
    private readonly area_: () => Area,
    /** Of values, for the height of a view: as many as the scan has. */
    private readonly range_: () => number,
  ) {}

  listen(element: HTMLElement, signal: AbortSignal): void {
    const sample = (event: PointerEvent): Touching => {
      const box = element.getBoundingClientRect();
      return { id: event.pointerId, x: event.clientX - box.left, y: event.clientY - box.top, touch: event.pointerType === "touch", button: event.button, shift: event.shiftKey };
    };
    const passive = { signal, passive: true };
    element.addEventListener("pointerdown", (event) => {
      element.setPointerCapture(event.pointerId);
      this.do_all(this.hands_.down(sample(event)));
    }, passive);
    element.addEventListener("pointermove", (event) => {
      const now = sample(event);
      if (!now.touch) this.slices_.pointed.value = { plane: this.stack_().plane, place: this.place_at(now) };
      this.do_all(this.hands_.move(now));
    }, passive);
    const up = (lost: boolean) => (event: PointerEvent) => {
      this.do_all(this.hands_.up(event.pointerId, lost));
      this.begun_ = null;
    };
    element.addEventListener("pointerup", up(false), passive);
    element.addEventListener("pointercancel", up(true), passive);
    element.addEventListener("pointerleave", () => (this.slices_.pointed.value = null), passive);
    element.addEventListener("dblclick", () => {
      if (["ruler", "angle"].includes(this.slices_.tool.value)) return; // two points, one after the other
      this.slices_.maximise(this.stack_().plane);
    }, passive);
    element.addEventListener("wheel", (event) => {
      event.preventDefault();
      if (event.ctrlKey) {
        const at = { x: event.offsetX, y: event.offsetY };
        this.do_all([{ kind: "zoom", factor: wheel_zoom(event.deltaY, event.deltaMode, true), at }]);
      } else {
        const slices = this.wheel_.slices(event.deltaY, event.deltaMode);
        if (slices !== 0) this.do_all([{ kind: "scroll", slices }]);
      }
    }, { signal, passive: false });
    element.addEventListener("touchmove", no_flick, { signal, passive: false });
    element.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });
    element.addEventListener("mousedown", (event) => {
      if (event.button === 1) event.preventDefault(); // the browser's own scrolling
    }, { signal });
  }

  /** Whether the key was one of the slice's. */
  key(event: KeyboardEvent): boolean {
    const stack = this.stack_();
    const slices = this.slices_;
    if (event.altKey || event.metaKey) return false;
    const way = arrows[event.key];
    if (way) {
      const [right, down] = way;
      if (event.shiftKey) slices.step(stack, right, down);
      else if (event.ctrlKey) this.pan({ x: 24 * right, y: 24 * down });
      else slices.scroll(stack, right + down);
      return true;
    }
    if (event.ctrlKey) return false;
    const middle = { x: this.area_().width / 2, y: this.area_().height / 2 };
    switch (event.key) {
      case "PageDown":
      case "PageUp":
        slices.scroll(stack, event.key === "PageDown" ? 10 : -10);
        return true;
      case "Home":
        slices.go_to(stack, 0);
        return true;
      case "End":
        slices.go_to(stack, stack.slices - 1);
        return true;
      case "+":
      case "=":
        this.zoom(zoom_step, middle);
        return true;
      case "-":
      case "_":
        this.zoom(1 / zoom_step, middle);
        return true;
      case "Enter":
        this.set_point(slices.crosshair.value);
        return true;
      case "Delete":
      case "Backspace":
        slices.measures.value = without_last(slices.measures.value);
        return true;
      case "r":
      case "R":
        slices.reset();
        return true;
      default:
        return false;
    }
  }

  private do_all(deeds: readonly Deed[]): void {
    for (const deed of deeds) this.do_one(deed);
  }

  private do_one(deed: Deed): void {
    const slices = this.slices_;
    switch (deed.kind) {
      case "begin":
        this.begun_ = slices.window.value;
        if (slices.tool.value === "ruler" || slices.tool.value === "angle") {
          this.set_point(this.place_at(deed.at));
          if (slices.measures.value.at(-1)?.points.length === 1) this.set_point(this.place_at(deed.at)); // the end, under the hand
        }
        break;
      case "drag":
        this.drag(deed.from, deed.at);
        break;
      case "tap":
        if (slices.tool.value === "crosshair") this.cross(deed.at);
        else this.set_point(this.place_at(deed.at));
        break;
      case "cross":
        this.cross(deed.at);
        break;
      case "pan":
        this.pan(deed.by);
        break;
      case "zoom":
        this.zoom(deed.factor, deed.at);
        break;
      case "scroll":
        slices.scroll(this.stack_(), deed.slices);
        break;
    }
  }

  private drag(from: Point, at: Point): void {
    const slices = this.slices_;
    switch (slices.tool.value) {
      case "window": {
        const { height } = this.area_();
        const begun = this.begun_ ?? slices.window.value;
        slices.set_window(dragged(begun, (at.x - from.x) / height, (at.y - from.y) / height, this.range_()));
        break;
      }
      case "crosshair":
        this.cross(at);
        break;
      case "ruler":
      case "angle":
        slices.measures.value = with_last_point(slices.measures.value, this.place_at(at));
        break;
    }
  }

  private set_point(place: Vec3): void {
    const { tool, measures } = this.slices_;
    const stack = this.stack_();
    const kind = tool.value;
    if (kind !== "ruler" && kind !== "angle") return;
    measures.value = with_point(measures.value, kind, stack.plane, this.slices_.index(stack), place);
  }

  private cross(at: Point): void {
    this.slices_.point_at(this.stack_(), this.place_at(at));
  }

  private pan({ x, y }: Point): void {
    const stack = this.stack_();
    this.slices_.place(stack, panned(stack, this.slices_.placing(stack), this.area_(), x, y));
  }

  private zoom(factor: number, at: Point): void {
    const stack = this.stack_();
    this.slices_.place(stack, zoomed(stack, this.slices_.placing(stack), this.area_(), factor, at));
  }

  /** In the middle of the slice's thickness. */
  private place_at(at: Point): Vec3 {
    const stack = this.stack_();
    return place_of(stack, { ...pixel_at(stack, this.slices_.placing(stack), this.area_(), at), slice: this.slices_.index(stack) });
  }
}

const arrows: Readonly<Record<string, readonly [number, number]>> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
