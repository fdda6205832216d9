import { useEffect } from "preact/hooks";
import type { DataSet } from "../../api/types";
import { MarkLibrary } from "../../marks/library";
import type { ViewerSession } from "../../video/viewer_session";
import { useApp } from "../state";

export interface OpenLibraryProps {
  readonly session: ViewerSession;
  readonly dataSetId: string;
  /** The facts about the scan, which only users with an account get. */
  readonly set: DataSet | null;
  /** Whether the viewer has an account that may open the scan. */
  readonly own: boolean;
}

/** Loads the marks that are saved with the scan, and saves their changes. */
export function OpenLibrary({ session, dataSetId, set, own }: OpenLibraryProps) {
  const { api } = useApp();
  // The slices restore the measurements of this tab first.
  const ready = session.volume.value !== null && (set !== null || !own);
  const saves = set !== null && (set.owned || set.role === "shared-edit" || set.is_public);
  const shares = set?.owned ?? false;
  useEffect(() => {
    if (!ready) return;
    const library = new MarkLibrary({
      api: api.annotations,
      dataSetId,
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
  }, [api, session, dataSetId, ready, saves, shares]);
  return null;
}
