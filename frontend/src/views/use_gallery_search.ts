import { useEffect, useState } from "preact/hooks";
import type { DataSet, GalleryQuery } from "../api/types";
import { useApp } from "./state";

const typingDelayMs = 300;
export const wholeGallery: GalleryQuery = { q: "", body_part: "", modality: "" };

/** Searches the gallery a moment after the last change of the query, or again when `known` changes. */
export function useGallerySearch(known: boolean) {
  const app = useApp();
  const [question, setQuestion] = useState(wholeGallery);
  const [found, setFound] = useState<readonly DataSet[] | null>(null);
  const [cursor, setCursor] = useState<string | null>(null);
  const [fault, setFault] = useState("");
  useEffect(() => {
    const leaving = new AbortController();
    const search = () =>
      app.api.sharing.gallery(question, null, leaving.signal).then(
        (page) => {
          setFound(page.items);
          setCursor(page.next_cursor);
          setFault("");
        },
        (thrown: unknown) => {
          if (!leaving.signal.aborted) setFault(app.explain(thrown));
        },
      );
    const timer = setTimeout(() => void search(), question === wholeGallery ? 0 : typingDelayMs);
    return () => {
      clearTimeout(timer);
      leaving.abort();
    };
  }, [app, question, known]);
  const loadMore = () => {
    app.api.sharing.gallery(question, cursor).then(
      (page) => {
        setFound([...(found ?? []), ...page.items]);
        setCursor(page.next_cursor);
      },
      (thrown: unknown) => setFault(app.explain(thrown)),
    );
  };
  const ask = (part: Partial<GalleryQuery>) => setQuestion({ ...question, ...part });
  return { question, ask, found, more: cursor !== null, fault, loadMore };
}
