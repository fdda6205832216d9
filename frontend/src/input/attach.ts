import { Gestures, wheelZoom, type Gesture } from "./gestures";
import { pointerSampleOf } from "./pointer_sample";
import { preventBrowserGestures } from "./prevent_browser_gestures";

/**
 * Listens to the gestures on `element` until `signal` is aborted. `rested` is called when the last pointer that acted is
 * lifted.
 */
export function attachGestures(
  element: HTMLElement,
  act: (gesture: Gesture, held: boolean) => void,
  rested: () => void,
  signal: AbortSignal,
): void {
  const gestures = new Gestures();
  let acted = false;
  const passive = { signal, passive: true };
  element.addEventListener(
    "pointerdown",
    (event) => {
      gestures.down(pointerSampleOf(event, element));
      element.setPointerCapture(event.pointerId);
      element.dataset.held = "";
    },
    passive,
  );
  const moved = (event: PointerEvent) => {
    if (!gestures.active) return;
    const area = { width: element.clientWidth, height: element.clientHeight };
    for (const gesture of gestures.move(pointerSampleOf(event, element), area)) {
      acted = true;
      act(gesture, true);
    }
  };
  listenToMoves(element, moved, signal);
  const released = (event: PointerEvent) => {
    gestures.up(event.pointerId);
    if (gestures.active) return;
    delete element.dataset.held;
    if (acted) rested();
    acted = false;
  };
  element.addEventListener("pointerup", released, passive);
  element.addEventListener("pointercancel", released, passive);
  element.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault(); // keeps the page from scrolling
      act({ kind: "zoom", factor: wheelZoom(event.deltaY, event.deltaMode, event.ctrlKey) }, false);
    },
    { signal, passive: false },
  );
  preventBrowserGestures(element, signal);
}

/**
 * Listens to moves. Browsers report them with the next screen refresh, some of them earlier as raw
 * updates. The first raw update after a refresh is used at once. Later ones are not, because a
 * mouse may send a thousand per second.
 */
function listenToMoves(element: HTMLElement, moved: (event: PointerEvent) => void, signal: AbortSignal): void {
  const passive = { signal, passive: true };
  let early = false;
  const movedEarly = (event: Event) => {
    if (early || !(event instanceof PointerEvent)) return;
    early = true;
    requestAnimationFrame(() => (early = false));
    moved(event);
  };
  element.addEventListener("pointermove", moved, passive);
  element.addEventListener("pointerrawupdate", movedEarly, passive);
}
