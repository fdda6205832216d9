import { noFlick } from "./no_flick";

/** Keeps the browser from scrolling the page or opening its menu while `element` is used. */
export function preventBrowserGestures(element: HTMLElement, signal: AbortSignal): void {
  element.addEventListener("touchmove", noFlick, { signal, passive: false });
  element.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });
  element.addEventListener(
    "mousedown",
    (event) => {
      if (event.button === 1) event.preventDefault(); // the middle button would start the browser's autoscroll
    },
    { signal },
  );
}
