import { useEffect, useState } from "preact/hooks";
import type { DataSet } from "../api/types";
import { useApp } from "./state";
import { wholeGallery } from "./use_gallery_search";

/**
 * The samples of this installation, or null until they are known. CT scans come last, because a
 * skull can frighten newcomers. Samples of one kind are sorted by age, the oldest first. An
 * installation may have none.
 */
export function useSamples(): readonly DataSet[] | null {
  const app = useApp();
  const [samples, setSamples] = useState<readonly DataSet[] | null>(null);
  useEffect(() => {
    const leaving = new AbortController();
    app.api.sharing.gallery(wholeGallery, null, leaving.signal).then(
      ({ items }) => setSamples(inOrder(items.filter((set) => set.is_sample))),
      () => {
        if (!leaving.signal.aborted) setSamples([]); // the page is complete without them
      },
    );
    return () => leaving.abort();
  }, [app]);
  return samples;
}

const isCt = (set: DataSet): boolean => set.volume?.modality === "CT";

const inOrder = (samples: readonly DataSet[]): readonly DataSet[] =>
  [...samples].sort((a, b) => Number(isCt(a)) - Number(isCt(b)) || a.created_at.localeCompare(b.created_at));
