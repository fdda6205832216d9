import { useEffect } from "preact/hooks";
import type { DataSet } from "../../api/types";
import type { Place } from "../../live/place";
import { MarkLibrary } from "../../marks/library";
import type { ViewerSession } from "../../video/viewer_session";
import { useApp } from "../state";

export interface OpenLibraryProps {
  readonly session: ViewerSession;
  readonly place: Pick<Place, "data_set_id" | "savedMarks">;
  /** The facts about the scan, which only users with an account get. */
  readonly set: DataSet | null;
  /** Whether the viewer has an account that may open the scan. */
  readonly own: boolean;
}

/** Loads the marks that are saved with the scan, and saves their changes. */
export function OpenLibrary({ session, place, set, own }: OpenLibraryProps) {
  const { api } = useApp();
  // Waits for the volume, because the slices restore the measurements of this tab first.
  const ready = session.volume.value !== null && (set !== null || !own);
  const saves = set !== null && (set.owned || set.role === "shared-edit" || set.is_public);
  const shares = set?.owned ?? false;
  useEffect(() => {
    if (!ready || !place.savedMarks) return;
    const library = new MarkLibrary({
      api: api.annotations,
      list: place.savedMarks,
      dataSetId: place.data_set_id ?? "", // visitors without an account save nothing
      marks: session.marks,
      slices: session.slices,
      saves,
      shares,
      memory: session,
      after: (ms, task) => {
        const timer = setTimeout(task, ms);
        return () => clearTimeout(timer);
      },
    });
    session.library.value = library;
    library.load().catch(() => undefined); // the picture is shown without them
    const hidden = () => void library.save();
    addEventListener("pagehide", hidden);
    return () => {
      removeEventListener("pagehide", hidden);
      session.library.value = null;
      library.stop();
    };
  }, [api, session, place, ready, saves, shares]);
  return null;
}
