import { useEffect, useRef, useState } from "preact/hooks";
import { ApiProblem } from "../api/client";
import type { DataSet, PresetInfo, PresetName } from "../api/types";
import type { LookPictures } from "../live/place";
import { t } from "../texts";
import { Icon } from "./icons";
import { looksOfEvery } from "./looks";
import { useApp } from "./state";
import { TaskQueue } from "./task_queue";

/** Each picture is rendered on its first request, so requests run one by one and do not delay the viewer. */
const requests = new TaskQueue();

const longestWaitMs = 8000;
const mostTries = 60;

/** Whether the server is still rendering the picture or others before it. */
const isBeingMade = ({ kind }: ApiProblem): boolean => kind === "busy" || kind === "too-many";

/** Whether a further request for the picture may succeed. */
type Later = (problem: ApiProblem) => boolean;
const busy: Later = ({ status }) => status === 0 || status === 429 || status >= 500;
/** A preset's picture is rendered in the background and is missing until then. */
const notYet: Later = (problem) => problem.status === 404 || busy(problem);

export interface Picture {
  /** The URL of the picture, or null until it exists. It is requested again until then. */
  readonly url: string | null;
  /** Whether the server cannot render the picture now, or does not have it. */
  readonly missing: boolean;
}

/**
 * Requests the picture until it exists, and again when `name` changes.
 * Uses `fetch`, because an <img> cannot repeat a failed request.
 */
function usePicture(
  name: string,
  enabled: boolean,
  later: Later,
  load: (signal: AbortSignal) => Promise<Blob>,
): Picture {
  const [url, setUrl] = useState<string | null>(null);
  const [missing, setMissing] = useState(false);
  const newest = useRef(load);
  newest.current = load;
  useEffect(() => {
    if (!enabled) return;
    const leaving = new AbortController();
    let made: string | null = null;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const ask = async (tries: number): Promise<void> => {
      try {
        const picture = await requests.add(() => newest.current(leaving.signal));
        made = URL.createObjectURL(picture);
        setUrl(made);
      } catch (thrown) {
        if (leaving.signal.aborted) return;
        const again = thrown instanceof ApiProblem && later(thrown) && tries <= mostTries;
        setMissing(!again || !isBeingMade(thrown));
        if (!again) return;
        timer = setTimeout(
          () => void ask(tries + 1),
          Math.max(thrown.retryAfterMs, Math.min(longestWaitMs, 1000 * (tries + 1))),
        );
      }
    };
    void ask(0);
    return () => {
      leaving.abort();
      clearTimeout(timer);
      setUrl(null);
      setMissing(false);
      if (made !== null) URL.revokeObjectURL(made);
    };
  }, [name, enabled, later]);
  return { url, missing };
}

/** A data set's picture under a look that is offered for it. */
export function useThumbnail(dataSetId: string, preset: PresetName, enabled: boolean): Picture {
  const app = useApp();
  return usePicture(`${dataSetId} ${preset}`, enabled, busy, (signal) => app.api.thumbnail(dataSetId, preset, signal));
}

/** The picture of a look in the viewer. There is none without `pictures` or `look`. */
export function useLookPicture(pictures: LookPictures | null, look: PresetName | null): Picture {
  const load = (signal: AbortSignal) =>
    pictures && look ? pictures.load(look, signal) : Promise.reject(new Error("There is no picture."));
  return usePicture(`${pictures?.key} ${look}`, pictures !== null && look !== null, busy, load);
}

/** The picture of a saved preset. It is requested once it becomes visible. */
export function PresetPicture({ preset }: { readonly preset: PresetInfo }) {
  const app = useApp();
  const place = useRef<HTMLSpanElement>(null);
  const [visible, setVisible] = useState(false);
  useEffect(() => {
    const element = place.current;
    if (!element) return;
    const watch = new IntersectionObserver((entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      setVisible(true);
      watch.disconnect();
    });
    watch.observe(element);
    return () => watch.disconnect();
  }, []);
  const { url } = usePicture(`${preset.id} ${preset.etag}`, visible, notYet, (signal) =>
    app.api.presets.picture(preset, signal),
  );
  return url ? (
    <span class="saved-picture">
      <img src={url} alt={t.presets.picture(preset.name)} width={320} height={320} draggable={false} />
    </span>
  ) : (
    <span class="saved-picture saved-waits" ref={place}>
      <Icon name="clock" />
      {t.presets.noPictureYet}
    </span>
  );
}

/**
 * Requests pictures of these data sets before the user opens them, so that the viewer shows its looks immediately
 * instead of rendering them next to the view. Only the stream says which other looks a scan has.
 */
export function useWarmThumbnails(dataSets: readonly DataSet[]): void {
  const app = useApp();
  const wanted = dataSets.flatMap(({ id, volume }) =>
    volume ? looksOfEvery(volume.modality).map((look) => [id, look] as const) : [],
  );
  const newest = useRef(wanted);
  newest.current = wanted;
  const key = wanted.join();
  useEffect(() => {
    const leaving = new AbortController();
    for (const [id, look] of newest.current)
      void requests
        .addPreparation(async () => {
          if (!leaving.signal.aborted) await app.api.thumbnail(id, look, leaving.signal);
        })
        .catch(() => undefined); // a component that shows the picture requests it again
    return () => leaving.abort();
  }, [app, key]);
}
