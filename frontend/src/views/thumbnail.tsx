import { useEffect, useRef, useState } from "preact/hooks";
import { ApiProblem } from "../api/client";
import { preset_names, type PresetInfo, type PresetName } from "../api/types";
import { t } from "../texts";
import { useApp } from "./state";

/** Each picture is rendered when first asked for: one after the other, so that the view itself does not wait. */
let last_asked: Promise<unknown> = Promise.resolve();

function in_turn<T>(task: () => Promise<T>): Promise<T> {
  const result = last_asked.then(task, task);
  last_asked = result.catch(() => undefined);
  return result;
}

const longest_wait_ms = 8000;
const most_tries = 60;

/** Whether it is worth asking again for a picture. */
type Later = (problem: ApiProblem) => boolean;
const busy: Later = ({ status }) => status === 0 || status === 429 || status >= 500;
/** A preset's picture is made in the background: until then there is none. */
const not_yet: Later = (problem) => problem.status === 404 || busy(problem);

/**
 * The address of a picture; nothing while it is being made: it is asked for again, as it is when `name` changes.
 * Through `fetch`, as an <img> cannot ask again when there is none yet.
 */
function use_picture(name: string, wanted: boolean, later: Later, load: (signal: AbortSignal) => Promise<Blob>): string | null {
  const [url, set_url] = useState<string | null>(null);
  const newest = useRef(load);
  newest.current = load;
  useEffect(() => {
    if (!wanted) return;
    const leaving = new AbortController();
    let made: string | null = null;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const ask = async (tries: number): Promise<void> => {
      try {
        const picture = await in_turn(() => newest.current(leaving.signal));
        made = URL.createObjectURL(picture);
        set_url(made);
      } catch (thrown) {
        const again = thrown instanceof ApiProblem && later(thrown);
        if (leaving.signal.aborted || !again || tries > most_tries) return;
        timer = setTimeout(() => void ask(tries + 1), Math.max(thrown.retry_after_ms, Math.min(longest_wait_ms, 1000 * (tries + 1))));
      }
    };
    void ask(0);
    return () => {
      leaving.abort();
      clearTimeout(timer);
      set_url(null);
      if (made !== null) URL.revokeObjectURL(made);
    };
  }, [name, wanted, later]);
  return url;
}

/** A data set's picture under a look that every scan has. */
export function use_thumbnail(data_set_id: string, preset: PresetName, wanted: boolean): string | null {
  const app = useApp();
  return use_picture(`${data_set_id} ${preset}`, wanted, busy, (signal) => app.api.thumbnail(data_set_id, preset, signal));
}

/** What a saved preset shows: asked for once it comes into sight. */
export function PresetPicture({ preset }: { readonly preset: PresetInfo }) {
  const app = useApp();
  const place = useRef<HTMLSpanElement>(null);
  const [seen, set_seen] = useState(false);
  useEffect(() => {
    const element = place.current;
    if (!element) return;
    const watch = new IntersectionObserver((entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      set_seen(true);
      watch.disconnect();
    });
    watch.observe(element);
    return () => watch.disconnect();
  }, []);
  const url = use_picture(`${preset.id} ${preset.etag}`, seen, not_yet, (signal) => app.api.presets.picture(preset, signal));
  return (
    <span class={`saved-picture${url ? "" : " card-working"}`} ref={place}>
      {url ? <img src={url} alt={t.presets.picture(preset.name)} width={320} height={320} draggable={false} /> : null}
    </span>
  );
}

/**
 * Has the pictures of these data sets made while nobody waits for them: the viewer then has its looks at once,
 * instead of rendering them beside the view.
 */
export function use_warm_thumbnails(data_set_ids: readonly string[]): void {
  const app = useApp();
  const key = data_set_ids.join(" ");
  useEffect(() => {
    const leaving = new AbortController();
    for (const id of key.split(" ").filter(Boolean))
      for (const preset of preset_names)
        void in_turn(async () => {
          if (!leaving.signal.aborted) await app.api.thumbnail(id, preset, leaving.signal);
        }).catch(() => undefined); // whoever shows it asks again
    return () => leaving.abort();
  }, [app, key]);
}
