import type { Viewport } from "../protocol/messages";

/**
 * A size is reported when it has not changed for `settledAfterMs`. A size that keeps changing is
 * reported every `reportedEveryMs`.
 */
export const settledAfterMs = 100;
export const reportedEveryMs = 400;

export interface Clock {
  readonly nowMs: () => number;
  /** Returns a function that cancels the task. */
  readonly after: (ms: number, task: () => void) => () => void;
}

/** Limits how often a changing size is reported, because the server starts a new picture for each size. */
export class ResizeDebouncer {
  private reported: Viewport;
  private current: Viewport;
  private changingSince = 0;
  private disarm: (() => void) | null = null;

  constructor(
    first: Viewport,
    private readonly report: (size: Viewport) => void,
    private readonly clock: Clock,
  ) {
    this.reported = first;
    this.current = first;
  }

  changed(size: Viewport): void {
    if (same(size, this.current)) return;
    this.current = size;
    const now = this.clock.nowMs();
    if (this.disarm) this.disarm();
    else this.changingSince = now;
    const left = this.changingSince + reportedEveryMs - now;
    this.disarm = this.clock.after(Math.max(0, Math.min(settledAfterMs, left)), () => {
      this.disarm = null;
      if (same(this.current, this.reported)) return;
      this.reported = this.current;
      this.report(this.current);
    });
  }

  stop(): void {
    this.disarm?.();
    this.disarm = null;
  }
}

const same = (a: Viewport, b: Viewport): boolean => a.width === b.width && a.height === b.height;

/** Reports the element's size in device pixels now and whenever it or the screen's pixel ratio changes. */
export function watchDevicePixels(element: HTMLElement, changed: (size: Viewport) => void, signal: AbortSignal): void {
  const observer = new ResizeObserver(([entry]) => {
    const exact = (entry as Partial<ResizeObserverEntry> | undefined)?.devicePixelContentBoxSize?.[0];
    changed(exact ? { width: exact.inlineSize, height: exact.blockSize } : devicePixels(element));
  });
  try {
    observer.observe(element, { box: "device-pixel-content-box" });
  } catch {
    observer.observe(element); // Safari: the size is rounded, and half a pixel off at fractional ratios
  }
  signal.addEventListener("abort", () => observer.disconnect());
}

/**
 * Returns the size that the layout suggests, as the observer will report it, for use before its
 * first report.
 */
export function devicePixels(element: HTMLElement): Viewport {
  return snapped(element.getBoundingClientRect(), devicePixelRatio);
}

/** Returns the device pixels that a box covers: browsers move each of its edges to the nearest pixel. */
export function snapped(box: Pick<DOMRectReadOnly, "left" | "right" | "top" | "bottom">, ratio: number): Viewport {
  const between = (from: number, to: number): number => Math.round(to * ratio) - Math.round(from * ratio);
  return { width: between(box.left, box.right), height: between(box.top, box.bottom) };
}
