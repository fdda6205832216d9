import { useEffect, useState } from "preact/hooks";
import { ApiProblem } from "../api/client";
import { preset_names, type PresetName } from "../api/types";
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

/**
 * The address of a data set's picture under a preset; nothing while it is being made: it is asked for again.
 * Through `fetch`, as an <img> cannot ask again when a renderer is not there yet.
 */
export function use_thumbnail(data_set_id: string, preset: PresetName, wanted: boolean): string | null {
  const app = useApp();
  const [url, set_url] = useState<string | null>(null);
  useEffect(() => {
    if (!wanted) return;
    const leaving = new AbortController();
    let made: string | null = null;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const ask = async (tries: number): Promise<void> => {
      try {
        const picture = await in_turn(() => app.api.thumbnail(data_set_id, preset, leaving.signal));
        made = URL.createObjectURL(picture);
        set_url(made);
      } catch (thrown) {
        const later = thrown instanceof ApiProblem && (thrown.status === 0 || thrown.status === 429 || thrown.status >= 500);
        if (leaving.signal.aborted || !later || tries > most_tries) return;
        timer = setTimeout(() => void ask(tries + 1), Math.max(thrown.retry_after_ms, Math.min(longest_wait_ms, 1000 * (tries + 1))));
      }
    };
    void ask(0);
    return () => {
      leaving.abort();
      clearTimeout(timer);
      if (made !== null) URL.revokeObjectURL(made);
    };
  }, [app, data_set_id, preset, wanted]);
  return url;
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
