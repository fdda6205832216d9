import { attachGestures } from "../../input/attach";
import type { Point } from "../../input/flat";
import { attachPointing } from "../../input/pointing";
import { watchDevicePixels } from "../../video/canvas_size";
import type { ViewerSession } from "../../video/viewer_session";

/** Connects a session to the events of the page and to the gestures on the picture, until `signal` is aborted. */
export function connectPage(session: ViewerSession, element: HTMLCanvasElement, signal: AbortSignal): void {
  const area = () => ({ width: element.clientWidth, height: element.clientHeight });
  // Attached before the gestures, so that a pointing finger makes none.
  const pointing = {
    isSeen: () => session.collaboration.points.value,
    point: (at: Point | null) => session.pointAt(at, area()),
  };
  attachPointing(element, pointing, signal);
  attachGestures(
    element,
    (gesture, held) => session.editor.act(gesture, held),
    () => session.editor.rest(),
    signal,
  );
  watchDevicePixels(
    element,
    (size) => {
      if (size.width > 0) session.resize(size); // the canvas has no size while a single slice covers it
    },
    signal,
  );
  const updateVisible = () => session.setVisible(!document.hidden && session.slices.pictureShown.value);
  document.addEventListener("visibilitychange", updateVisible, { signal });
  element.addEventListener("contextrestored", () => session.showAnew(), { signal }); // the picture was lost together with the GPU context
  const unsubscribe = session.slices.pictureShown.subscribe(updateVisible);
  signal.addEventListener("abort", unsubscribe);
  addEventListener("online", () => session.wake(), { signal });
  addEventListener("offline", () => session.checkNetwork(), { signal });
  addEventListener("pagehide", () => session.remember(), { signal });
}
