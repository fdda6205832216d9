import { useEffect, useState } from "preact/hooks";
import { useApp } from "./state";
import { useLatest } from "./use_latest";

/** A list that is read page by page. `begin` reads the first page again, for example after a change of the filter. */
export function usePages<T>(
  load: (cursor: string | null) => Promise<{ items: readonly T[]; next_cursor: string | null }>,
) {
  const app = useApp();
  const [items, setItems] = useState<readonly T[] | null>(null);
  const [next, setNext] = useState<string | null>(null);
  const [wrong, setWrong] = useState("");
  const read = (cursor: string | null, before: readonly T[]) => {
    load(cursor).then(
      (page) => {
        setItems([...before, ...page.items]);
        setNext(page.next_cursor);
        setWrong("");
      },
      (thrown: unknown) => setWrong(app.explain(thrown)),
    );
  };
  const begin = () => read(null, []);
  const latestBegin = useLatest(begin);
  useEffect(() => latestBegin.current(), [app, latestBegin]);
  return { items, next, wrong, begin, more: () => read(next, items ?? []) };
}
