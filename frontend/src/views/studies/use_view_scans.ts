import { useEffect, useState } from "preact/hooks";
import type { DataSet } from "../../api/types";
import { useApp } from "../state";

/** Returns the scans that a study may show: the researcher's own, and those that are public or samples. */
export function useViewScans(): readonly DataSet[] | null {
  const app = useApp();
  const [scans, setScans] = useState<readonly DataSet[] | null>(null);
  useEffect(() => {
    const leaving = new AbortController();
    app.api.dataSets(leaving.signal).then(
      (all) => setScans(all.filter((one) => one.state === "ready" && (one.owned || one.is_public || one.is_sample))),
      () => undefined,
    );
    return () => leaving.abort();
  }, [app]);
  return scans;
}
