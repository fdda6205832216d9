import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { attachPointing } from "./pointing";
import type { Point } from "./flat";

/** A pointer event as far as pointing reads it. */
class FakePointerEvent extends Event {
  readonly pointerId: number;
  readonly pointerType: string;
  readonly clientX: number;
  readonly clientY: number;
  readonly buttons: number;
  override readonly isTrusted: boolean = false;

  constructor(kind: string, init: PointerEventInit = {}) {
    super(kind, { cancelable: true });
    this.pointerId = init.pointerId ?? 1;
    this.pointerType = init.pointerType ?? "mouse";
    this.clientX = init.clientX ?? 0;
    this.clientY = init.clientY ?? 0;
    this.buttons = init.buttons ?? 0;
  }
}

describe("pointing", () => {
  let element: HTMLElement;
  let points: (Point | null)[];
  let gestures: string[];
  let seen: boolean;
  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("PointerEvent", FakePointerEvent);
    points = [];
    gestures = [];
    seen = true;
    const target = new EventTarget();
    element = Object.assign(target, { getBoundingClientRect: () => ({ left: 10, top: 20 }) }) as unknown as HTMLElement;
    attachPointing(element, { isSeen: () => seen, point: (at) => points.push(at) }, new AbortController().signal);
    for (const kind of ["pointerdown", "pointermove", "pointerup", "pointercancel"])
      target.addEventListener(kind, () => gestures.push(kind));
  });
  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });
  const send = (kind: string, init: PointerEventInit) => element.dispatchEvent(new FakePointerEvent(kind, init));
  const finger = (kind: string, clientX: number, pointerId = 1) =>
    send(kind, { pointerType: "touch", clientX, clientY: 20, pointerId });

  it("follows a mouse without a button until it leaves", () => {
    send("pointermove", { clientX: 15, clientY: 26 });
    send("pointermove", { clientX: 90, clientY: 90, buttons: 1 });
    send("pointerleave", {});
    expect(points).toEqual([{ x: 5, y: 6 }, null]);
  });

  it("starts when a finger is held in place, which then makes no gesture", () => {
    finger("pointerdown", 30);
    finger("pointermove", 33);
    vi.advanceTimersByTime(500);
    finger("pointermove", 60);
    finger("pointerup", 60);
    expect(points).toEqual([
      { x: 20, y: 0 },
      { x: 50, y: 0 },
    ]);
    expect(gestures).toEqual(["pointerdown", "pointermove", "pointercancel"]);
  });

  it("does not start for a finger that moves, or for two fingers", () => {
    finger("pointerdown", 30);
    finger("pointermove", 60);
    vi.advanceTimersByTime(500);
    finger("pointerup", 60);
    finger("pointerdown", 30);
    finger("pointerdown", 90, 2);
    vi.advanceTimersByTime(500);
    expect(points).toEqual([]);
    expect(gestures).not.toContain("pointercancel");
  });

  it("leaves everything to the gestures while the viewer is alone", () => {
    seen = false;
    send("pointermove", { clientX: 15, clientY: 26 });
    finger("pointerdown", 30);
    vi.advanceTimersByTime(500);
    finger("pointermove", 31);
    expect(points).toEqual([]);
    expect(gestures).toEqual(["pointermove", "pointerdown", "pointermove"]);
  });
});
