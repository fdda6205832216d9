import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";

/** Returns a reference to a row that scrolls into view once it is chosen, for example by a press in the picture. */
export function useMarked(chosen: boolean): RefObject<HTMLLIElement | null> {
  const row = useRef<HTMLLIElement>(null);
  useEffect(() => {
    if (chosen) row.current?.scrollIntoView({ block: "nearest" });
  }, [chosen]);
  return row;
}
