import { useEffect, useState } from "preact/hooks";
import { ApiProblem } from "../../../api/client";
import type { ScanExport, ScanExportOrder } from "../../../api/scan_exports";
import { t } from "../../../texts";
import { useApp } from "../../state";

const askedAgainAfterMs = 1000;

export interface ScanExportTask {
  /** The user's export of this scan. Null if there is none, undefined until the server has responded. */
  readonly made: ScanExport | null | undefined;
  /** An error for the user, or empty. */
  readonly wrong: string;
  readonly request: (order: ScanExportOrder) => void;
  readonly remove: () => void;
}

/** The user's export of a scan, which is polled while it is queued. */
export function useScanExport(dataSetId: string): ScanExportTask {
  const app = useApp();
  const [made, setMade] = useState<ScanExport | null | undefined>(undefined);
  const [wrong, setWrong] = useState("");
  const [round, setRound] = useState(0);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let here = true;
    const learned = (state: ScanExport | null) => {
      if (!here) return;
      setMade(state);
      if (state?.state === "queued") timer = setTimeout(() => setRound(round + 1), askedAgainAfterMs);
    };
    app.api.scanExports.state(dataSetId).then(learned, (thrown: unknown) => {
      if (thrown instanceof ApiProblem && thrown.status === 404) learned(null);
      else if (here) setWrong(app.explain(thrown));
    });
    return () => {
      here = false;
      clearTimeout(timer);
    };
  }, [app, dataSetId, round]);
  const act = (what: Promise<unknown>) => {
    setWrong("");
    what.then(
      () => setRound(round + 1),
      (thrown: unknown) => {
        const busy = thrown instanceof ApiProblem && thrown.kind === "too-many";
        setWrong(busy ? t.scanFile.busy : app.explain(thrown));
      },
    );
  };
  return {
    made,
    wrong,
    request: (order) => act(app.api.scanExports.request(dataSetId, order)),
    remove: () => act(app.api.scanExports.remove(dataSetId)),
  };
}
