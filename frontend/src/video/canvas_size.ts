import type { Viewport } from "../protocol/messages";

/** A size that has not changed for so long is told; one that keeps changing at least this often. */
export const settled_after_ms = 100;
export const told_every_ms = 400;

export interface Clock {
  readonly now_ms: () => number;
  /** Gives back what takes the task away again. */
  readonly after: (ms: number, task: () => void) => () => void;
}

/** Each size that is told begins a new picture at the server, so a window under the mouse tells few of its many. */
export class SizeTeller {
  private told_: Viewport;
  private wanted_: Viewport;
  private changing_since_ = 0;
  private disarm_: (() => void) | null = null;

  constructor(
    first: Viewport,
    private readonly tell_: (size: Viewport) => void,
    private readonly clock_: Clock,
  ) {
    this.told_ = first;
    this.wanted_ = first;
  }

  changed(size: Viewport): void {
    if (same(size, this.wanted_)) return;
    this.wanted_ = size;
    const now = this.clock_.now_ms();
    if (this.disarm_) this.disarm_();
    else this.changing_since_ = now;
    const left = this.changing_since_ + told_every_ms - now;
    this.disarm_ = this.clock_.after(Math.max(0, Math.min(settled_after_ms, left)), () => {
      this.disarm_ = null;
      if (same(this.wanted_, this.told_)) return;
      this.told_ = this.wanted_;
      this.tell_(this.wanted_);
    });
  }

  stop(): void {
    this.disarm_?.();
    this.disarm_ = null;
  }
}

const same = (a: Viewport, b: Viewport): boolean => a.width === b.width && a.height === b.height;

/** The element's own device pixels, now and at every change of its size or of the screen's pixel ratio. */
export function watch_device_pixels(element: HTMLElement, changed: (size: Viewport) => void, signal: AbortSignal): void {
  const observer = new ResizeObserver(([entry]) => {
    const exact = (entry as Partial<ResizeObserverEntry> | undefined)?.devicePixelContentBoxSize?.[0];
    changed(exact ? { width: exact.inlineSize, height: exact.blockSize } : device_pixels(element));
  });
  try {
    observer.observe(element, { box: "device-pixel-content-box" });
  } catch {
    observer.observe(element); // Safari: rounded, and half a pixel off at odd ratios
  }
  signal.addEventListener("abort", () => observer.disconnect());
}

/** Before anything was observed: as near as layout tells. */
export function device_pixels(element: HTMLElement): Viewport {
  const ratio = devicePixelRatio;
  return { width: Math.round(element.clientWidth * ratio), height: Math.round(element.clientHeight * ratio) };
}
