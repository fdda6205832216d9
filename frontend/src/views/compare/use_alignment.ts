import { useEffect, useState } from "preact/hooks";
import type { Alignment } from "../../api/alignments";
import { startPolling } from "../polling";
import { useApp } from "../state";

const pollMs = { changing: 1500, settled: 30_000 } as const;

export interface AlignmentTask {
  /** Undefined until the server has responded. */
  readonly found: Alignment | undefined;
  /** An error for the user, or empty. */
  readonly fault: string;
  readonly busy: boolean;
  readonly request: () => void;
  readonly remove: () => void;
  /** Discards a result and aligns the scans again. */
  readonly again: () => void;
}

export const isAligning = (found: Alignment | undefined): boolean =>
  found?.state === "waiting" || found?.state === "running";

/** How the second scan lies in the space of the first one. Polled while the server aligns them. */
export function useAlignment(first: string, second: string): AlignmentTask {
  const app = useApp();
  const [found, setFound] = useState<Alignment | undefined>(undefined);
  const [fault, setFault] = useState("");
  const [busy, setBusy] = useState(false);
  useEffect(() => {
    if (first === second) return; // one scan in two looks
    let here = true;
    const round = async () => {
      try {
        const now = await app.api.alignments.state(first, second);
        if (!here) return pollMs.settled;
        setFound((before) => (JSON.stringify(before) === JSON.stringify(now) ? before : now));
        setFault("");
        return isAligning(now) ? pollMs.changing : pollMs.settled;
      } catch (thrown) {
        if (here) setFault(app.explain(thrown));
        return pollMs.settled;
      }
    };
    const polling = startPolling(round);
    return () => {
      here = false;
      polling.stop();
    };
    // A request ends the pause.
  }, [app, first, second, busy]);
  const act = (what: () => Promise<unknown>) => {
    if (busy) return;
    setBusy(true);
    setFault("");
    what()
      .catch((thrown: unknown) => setFault(app.explain(thrown)))
      .finally(() => setBusy(false));
  };
  const { alignments } = app.api;
  return {
    found,
    fault,
    busy,
    request: () => act(() => alignments.request(first, second)),
    remove: () => act(() => alignments.remove(first, second)),
    again: () => act(() => alignments.remove(first, second).then(() => alignments.request(first, second))),
  };
}
