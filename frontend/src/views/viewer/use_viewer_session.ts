import type { RefObject } from "preact";
import { useEffect, useState } from "preact/hooks";
import type { Place } from "../../live/place";
import { local } from "../../storage";
import { t } from "../../texts";
import { devicePixels } from "../../video/canvas_size";
import { chosenCodecs, probeCodecs } from "../../video/ladder";
import { Painter } from "../../video/painter";
import { probeStills } from "../../video/tile_pixels";
import { ViewerSession } from "../../video/viewer_session";
import { connectPage } from "./connect_page";

/** Opens a session that draws on the canvas and ends with the page. Null until the codecs have been tested. */
export function useViewerSession(place: Place, canvas: RefObject<HTMLCanvasElement | null>) {
  const [session, setSession] = useState<ViewerSession | null>(null);
  const [fault, setFault] = useState("");
  useEffect(() => {
    const element = canvas.current;
    if (!element) return;
    if (document.activeElement === document.body) element.focus(); // the link that led here no longer exists
    const leaving = new AbortController();
    let opened: ViewerSession | null = null;
    void Promise.all([probeCodecs(chosenCodecs(local)), probeStills()]).then(([codecs, stills]) => {
      if (leaving.signal.aborted) return;
      if (codecs.length === 0) {
        setFault(t.viewer.noCodec);
        return;
      }
      opened = new ViewerSession(place, new Painter(element), devicePixels(element), { codecs, stills }, local);
      connectPage(opened, element, leaving.signal);
      opened.start();
      setSession(opened);
    });
    return () => {
      leaving.abort();
      opened?.leave();
    };
  }, [place, canvas]);
  return { session, fault };
}
