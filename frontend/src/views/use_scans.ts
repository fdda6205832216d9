import { useEffect, useState } from "preact/hooks";
import { ApiProblem } from "../api/client";
import type { DataSet } from "../api/types";
import { isOpen } from "../api/upload_view";
import { t } from "../texts";
import { startPolling } from "./polling";
import { useApp, type AppState } from "./state";

/**
 * Intervals between requests, short enough for a user who looks at the list to learn within 3 s
 * that the server is unavailable.
 */
const pollMs = { idle: 2500, hidden: 15_000, changing: 1500, failed: 2500 } as const;

/** The user's scans. The list is polled, more often while one of them changes. */
export function useScans() {
  const app = useApp();
  const [sets, setSets] = useState<readonly DataSet[] | null>(null);
  const [fault, setFault] = useState("");
  const [round, setRound] = useState(0);
  const open = [...app.uploads.views.value.values()].filter(isOpen).length;
  useEffect(() => {
    const leaving = new AbortController();
    const load = async (): Promise<number> => {
      try {
        const [found, me] = await Promise.all([app.api.dataSets(leaving.signal), app.api.me()]);
        if (leaving.signal.aborted) return pollMs.idle;
        setSets(found);
        app.me.value = me; // the quota has changed with the list
        setFault("");
        for (const set of found) if (set.state !== "uploading") app.uploads.forgetSent(set.id);
        return found.some((set) => isChanging(set, app))
          ? pollMs.changing
          : document.hidden
            ? pollMs.hidden
            : pollMs.idle;
      } catch (thrown) {
        if (!leaving.signal.aborted) setFault(isServerAway(thrown) ? t.scans.serverAway : app.explain(thrown));
        return pollMs.failed;
      }
    };
    const polling = startPolling(load);
    // Reports a lost network immediately, and loads the list again when the network is back or the
    // page is visible again.
    for (const event of ["online", "offline"]) addEventListener(event, polling.now, { signal: leaving.signal });
    document.addEventListener("visibilitychange", () => document.hidden || polling.now(), { signal: leaving.signal });
    return () => {
      leaving.abort();
      polling.stop();
    };
    // The number of open uploads is a dependency, because an upload that ends changes the list at once.
  }, [app, round, open]);
  const remove = async (set: DataSet) => {
    try {
      await app.uploads.cancel(set.id);
    } catch (thrown) {
      setFault(app.explain(thrown));
    }
    setRound(round + 1);
  };
  /** Changes the title of a scan. Rejects with ApiProblem. */
  const rename = async (set: DataSet, title: string) => {
    const changed = await app.api.sharing.describe(set.id, { title });
    setSets((before) => before?.map((one) => (one.id === set.id ? changed : one)) ?? null);
  };
  const reload = () => setRound(round + 1);
  return { sets, fault, remove, rename, reload };
}

/**
 * Whether the server is unavailable. The list is then loaded again automatically, while other pages
 * report that the user's action has failed.
 */
const isServerAway = (thrown: unknown): boolean =>
  thrown instanceof ApiProblem && (thrown.kind === "unavailable" || thrown.kind === "busy");

const isChanging = (set: DataSet, app: AppState): boolean =>
  set.state === "queued" || set.state === "building" || app.uploads.views.peek().has(set.id);
