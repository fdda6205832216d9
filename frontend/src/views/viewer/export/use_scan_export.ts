import { useEffect, useMemo, useState } from "preact/hooks";
import { ApiProblem } from "../../../api/client";
import type { ScanExport, ScanExportOrder } from "../../../api/scan_exports";
import { t } from "../../../texts";
import { startPolling } from "../../polling";
import { useApp } from "../../state";

const askedAgainAfterMs = 1000;
/** While nothing is being made, or after an error. */
const askedAgainLaterMs = 10_000;

export interface ScanExportTask {
  /** The user's export of this scan. Null if there is none, undefined until the server has responded. */
  readonly made: ScanExport | null | undefined;
  /** An error for the user, or empty. */
  readonly wrong: string;
  /** Whether a request is under way. */
  readonly busy: boolean;
  readonly request: (order: ScanExportOrder) => void;
  readonly remove: () => void;
}

/** The user's export of a scan, which is polled. */
export function useScanExport(dataSetId: string): ScanExportTask {
  const app = useApp();
  const [made, setMade] = useState<ScanExport | null | undefined>(undefined);
  const [unknown, setUnknown] = useState("");
  const [refused, setRefused] = useState("");
  const [busy, setBusy] = useState(false);
  const state = useMemo(
    () => () =>
      app.api.scanExports.state(dataSetId).catch((thrown: unknown) => {
        if (thrown instanceof ApiProblem && thrown.status === 404) return null;
        throw thrown;
      }),
    [app, dataSetId],
  );
  useEffect(() => {
    let here = true;
    const round = async () => {
      try {
        const found = await state();
        if (!here) return askedAgainLaterMs;
        setMade(found);
        setUnknown("");
        return found?.state === "queued" ? askedAgainAfterMs : askedAgainLaterMs;
      } catch (thrown) {
        if (here) setUnknown(app.explain(thrown));
        return askedAgainLaterMs;
      }
    };
    const polling = startPolling(round);
    return () => {
      here = false;
      polling.stop();
    };
    // A request ends the pause.
  }, [app, state, busy]);
  const act = (what: () => Promise<unknown>) => {
    if (busy) return;
    setBusy(true);
    setRefused("");
    what()
      .then(state)
      .then(setMade, (thrown: unknown) => {
        const isOther = thrown instanceof ApiProblem && thrown.kind === "too-many";
        setRefused(isOther ? t.scanFile.busy : app.explain(thrown));
      })
      .finally(() => setBusy(false));
  };
  return {
    made,
    wrong: refused || unknown,
    busy,
    request: (order) => act(() => app.api.scanExports.request(dataSetId, order)),
    remove: () => act(() => app.api.scanExports.remove(dataSetId)),
  };
}
