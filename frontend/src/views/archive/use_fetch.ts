import { useEffect, useState } from "preact/hooks";
import type { Fetch } from "../../api/archives";
import { ApiProblem } from "../../api/client";
import { t } from "../../texts";
import { problemText } from "../../texts/problem_text";
import { startPolling } from "../polling";
import { useApp } from "../state";

const pollMs = 700;
/** Share of the whole that is fetching. The rest is the upload to the server's own storage. */
const fetchingPart = 0.7;

/** How far a fetch is, for a progress bar. Null until the archive has listed the images. */
export function progressOf({ state, images, total, uploaded }: Fetch): number | null {
  if (state === "uploading") return fetchingPart + (1 - fetchingPart) * uploaded;
  return total > 0 ? (fetchingPart * images) / total : null;
}

/** Why a fetch failed, and what to do. */
export function fetchFault(problem: string): string {
  const known: Readonly<Record<string, string>> = t.archive.problems;
  return known[problem] ?? problemText({ kind: problem, detail: "", errors: [] });
}

const progressText = ({ state, images, total }: Fetch): string =>
  state === "uploading" ? t.archive.preparing : total > 0 ? t.archive.fetched(images, total) : t.archive.starting;

/** The fetch of one series. It continues if the user leaves the page. */
export function useFetch(archive: string, study: string, series: string) {
  const app = useApp();
  const [fetch, setFetch] = useState<Fetch | null>(null);
  const [starting, setStarting] = useState(false);
  const [fault, setFault] = useState("");
  const id = fetch?.id;
  useEffect(() => {
    if (!id) return;
    const polling = startPolling(async () => {
      try {
        const now = await app.api.archives.status(archive, id);
        setFetch(now);
        if (now.state === "failed") setFault(fetchFault(now.problem ?? "internal"));
        if (["done", "failed", "cancelled"].includes(now.state)) polling.stop();
      } catch (thrown) {
        // The gateway forgets its fetches when it restarts.
        if (!(thrown instanceof ApiProblem && thrown.kind === "not-found")) return pollMs;
        setFetch(null);
        setFault(t.archive.lost);
        polling.stop();
      }
      return pollMs;
    });
    return polling.stop;
  }, [app, archive, id]);
  const start = (title: string) => {
    setFault("");
    setFetch(null);
    setStarting(true);
    app.api.archives
      .fetch(archive, { study, series, title })
      .then(setFetch, (thrown: unknown) => setFault(app.explain(thrown)))
      .finally(() => setStarting(false));
  };
  const cancel = () => {
    if (id) app.api.archives.cancel(archive, id).catch((thrown: unknown) => setFault(app.explain(thrown)));
  };
  const isRunning = fetch?.state === "fetching" || fetch?.state === "uploading";
  const running =
    fetch && isRunning
      ? { share: progressOf(fetch), text: progressText(fetch) }
      : starting
        ? { share: null, text: t.archive.starting }
        : null;
  return { running, done: fetch?.state === "done", fault, start, cancel };
}
