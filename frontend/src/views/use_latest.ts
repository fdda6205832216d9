import type { RefObject } from "preact";
import { useRef } from "preact/hooks";

/** A stable reference to the value of the latest render. An effect can use the value without running again when it changes. */
export function useLatest<T>(value: T): RefObject<T> {
  const latest = useRef(value);
  latest.current = value;
  return latest;
}
