import { Gestures, wheel_zoom, type Gesture, type PointerSample } from "./gestures";
import { no_flick } from "./no_flick";

/** Listens to the hands on `element` until the given signal is aborted. `rested`: the last one that moved was lifted. */
export function attach_gestures(
  element: HTMLElement,
  act: (gesture: Gesture, held: boolean) => void,
  rested: () => void,
  signal: AbortSignal,
): void {
  const gestures = new Gestures();
  let acted = false;
  const sample = (event: PointerEvent): PointerSample => {
    const box = element.getBoundingClientRect();
    return {
      id: event.pointerId,
      x: event.clientX - box.left,
      y: event.clientY - box.top,
      touch: event.pointerType === "touch",
      button: event.button,
      shift: event.shiftKey,
      ctrl: event.ctrlKey || event.metaKey,
    };
  };
  const passive = { signal, passive: true };

  element.addEventListener("pointerdown", (event) => {
    gestures.down(sample(event));
    element.setPointerCapture(event.pointerId);
    element.dataset.held = "";
  }, passive);
  const moved = (event: PointerEvent) => {
    if (!gestures.active) return;
    const area = { width: element.clientWidth, height: element.clientHeight };
    for (const gesture of gestures.move(sample(event), area)) {
      acted = true;
      act(gesture, true);
    }
  };
  element.addEventListener("pointermove", moved, passive);
  // A move is told with the next picture of the screen; by some browsers sooner, and then the first since the last
  // picture is acted on at once. Not the others: a mouse may tell a thousand a second.
  let early = false;
  const moved_early = (event: Event) => {
    if (early || !(event instanceof PointerEvent)) return;
    early = true;
    requestAnimationFrame(() => (early = false));
    moved(event);
  };
  element.addEventListener("pointerrawupdate", moved_early, passive);
  const released = (event: PointerEvent) => {
    gestures.up(event.pointerId);
    if (gestures.active) return;
    delete element.dataset.held;
    if (acted) rested();
    acted = false;
  };
  element.addEventListener("pointerup", released, passive);
  element.addEventListener("pointercancel", released, passive);
  element.addEventListener("touchmove", no_flick, { signal, passive: false });
  // These two would scroll the page and open the browser's menu.
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    act({ kind: "zoom", factor: wheel_zoom(event.deltaY, event.deltaMode, event.ctrlKey) }, false);
  }, { signal, passive: false });
  element.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });
  element.addEventListener("mousedown", (event) => {
    if (event.button === 1) event.preventDefault(); // the browser's own scrolling
  }, { signal });
}
