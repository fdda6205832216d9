import type { Point } from "./flat";
import { pointerSampleOf } from "./pointer_sample";

/** Time for which a finger must stay in place to start pointing. */
const holdMs = 450;
const stillPx = 10;

export interface Pointing {
  /** Whether anybody sees where the user points. Otherwise, a finger that is held down is not taken from the gestures. */
  readonly isSeen: () => boolean;
  /** Called with null when the mouse leaves. */
  readonly point: (at: Point | null) => void;
}

/**
 * Reports where the user points: a mouse that moves without a button, or a finger that is held down in one place and
 * then moved. Must listen before the gestures of the element, because a pointing finger makes none.
 */
export function attachPointing(element: HTMLElement, { isSeen, point }: Pointing, signal: AbortSignal): void {
  const held = new HeldFinger((id) => {
    // Makes the gestures release the finger.
    element.dispatchEvent(new PointerEvent("pointercancel", { pointerId: id, pointerType: "touch" }));
  }, point);
  const options = { signal, capture: true, passive: true };
  const stopped = (event: PointerEvent, isPointing: boolean) => {
    if (isPointing) event.stopImmediatePropagation();
  };
  element.addEventListener(
    "pointerdown",
    (event) => {
      if (event.pointerType === "touch" && isSeen()) held.down(pointerSampleOf(event, element));
    },
    options,
  );
  const moved = (event: PointerEvent) => {
    if (!isSeen()) return;
    const sample = pointerSampleOf(event, element);
    if (sample.touch) stopped(event, held.move(sample));
    else if (event.buttons === 0) point({ x: sample.x, y: sample.y });
  };
  element.addEventListener("pointermove", moved, options);
  element.addEventListener(
    "pointerrawupdate",
    (event) => {
      if (event instanceof PointerEvent && held.isPointing(event.pointerId)) event.stopImmediatePropagation();
    },
    options,
  );
  element.addEventListener("pointerup", (event) => stopped(event, held.up(event.pointerId)), options);
  element.addEventListener(
    "pointercancel",
    (event) => {
      if (event.isTrusted) held.up(event.pointerId);
    },
    options,
  );
  element.addEventListener(
    "pointerleave",
    (event) => {
      if (event.pointerType !== "touch") point(null);
    },
    options,
  );
  signal.addEventListener("abort", () => held.stop());
}

interface Finger extends Point {
  readonly id: number;
}

/** A finger that is about to point, or points. */
class HeldFinger {
  private finger: Finger | null = null;
  private pointing = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly begun: (id: number) => void,
    private readonly point: (at: Point) => void,
  ) {}

  isPointing(id: number): boolean {
    return this.pointing && this.finger?.id === id;
  }

  down({ id, x, y }: Finger): void {
    const isFirst = this.finger === null;
    if (this.pointing) return;
    this.stop();
    this.finger = { id, x, y };
    if (isFirst) this.timer = setTimeout(() => this.begin(), holdMs);
  }

  /** Returns whether the finger points. */
  move({ id, x, y }: Finger): boolean {
    const { finger } = this;
    if (finger?.id !== id) return false;
    if (this.pointing) this.point({ x, y });
    else if (Math.hypot(x - finger.x, y - finger.y) > stillPx) clearTimeout(this.timer);
    return this.pointing;
  }

  /**
   * Returns whether the finger pointed. The pointer stays in its last position until it expires.
   */
  up(id: number): boolean {
    const pointed = this.isPointing(id);
    if (this.finger?.id === id) this.stop();
    return pointed;
  }

  stop(): void {
    clearTimeout(this.timer);
    this.finger = null;
    this.pointing = false;
  }

  private begin(): void {
    if (!this.finger) return;
    this.pointing = true;
    this.begun(this.finger.id);
    this.point({ x: this.finger.x, y: this.finger.y });
  }
}
