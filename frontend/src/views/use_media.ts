import { useEffect, useState } from "preact/hooks";

/** A touch screen without a mouse. */
export const touchScreen = "(hover: none) and (pointer: coarse)";

/** Whether the window matches the media query, now and after changes. */
export function useMedia(query: string): boolean {
  const [matches, setMatches] = useState(() => matchMedia(query).matches);
  useEffect(() => {
    const list = matchMedia(query);
    const changed = () => setMatches(list.matches);
    changed();
    list.addEventListener("change", changed);
    return () => list.removeEventListener("change", changed);
  }, [query]);
  return matches;
}
