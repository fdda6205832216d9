import type { Area } from "../../input/flat";
import type { RefObject } from "preact";
import { useEffect, useState } from "preact/hooks";

/** Returns the current size of an element in CSS pixels. */
export function useScreen(area: RefObject<HTMLElement | null>): Area {
  const [screen, setScreen] = useState<Area>({ width: 1, height: 1 });
  useEffect(() => {
    const element = area.current;
    if (!element) return;
    const measure = () =>
      setScreen({ width: Math.max(1, element.clientWidth), height: Math.max(1, element.clientHeight) });
    measure();
    const watching = new ResizeObserver(measure);
    watching.observe(element);
    return () => watching.disconnect();
  }, [area]);
  return screen;
}
