import type { Point } from "../input/flat";
import type { PointerSample } from "../input/pointer_sample";

/** The action of a gesture in a slice view, as plain data. Lengths are in CSS pixels. */
export type GestureAction =
  | { readonly kind: "begin"; readonly at: Point }
  | { readonly kind: "drag"; readonly from: Point; readonly at: Point; readonly by: Point }
  | { readonly kind: "tap"; readonly at: Point }
  | { readonly kind: "cross"; readonly at: Point }
  | { readonly kind: "pan"; readonly by: Point }
  | { readonly kind: "zoom"; readonly factor: number; readonly at: Point }
  | { readonly kind: "scroll"; readonly slices: number };

type Mode = "tool" | "cross" | "pan" | "zoom";
interface Held {
  readonly mode: Mode;
  readonly begun: Point;
  readonly at: Point;
  readonly moved: boolean;
}

/**
 * Minimum movement of a drag in CSS pixels. A shorter one is a tap with a slightly moving pointer.
 */
const still = 4;
const scrollEvery = 12;

/**
 * Translates pointer events to actions: one finger or the left button uses the tool, two fingers move and zoom, and
 * three scroll.
 */
export class SliceGestures {
  private readonly held = new Map<number, Held>();
  /** Whether several fingers were down, so that the remaining ones do not use the tool. */
  private many = false;
  private scrolled = 0;

  down(sample: PointerSample): readonly GestureAction[] {
    const mode: Mode = sample.touch
      ? "tool"
      : sample.button === 1
        ? "pan"
        : sample.button === 2
          ? "zoom"
          : sample.shift
            ? "cross"
            : "tool";
    const at = { x: sample.x, y: sample.y };
    this.held.set(sample.id, { mode, begun: at, at, moved: false });
    this.many = this.held.size > 1;
    this.scrolled = 0;
    return mode === "cross" && !this.many ? [{ kind: "cross", at }] : [];
  }

  move(sample: PointerSample): readonly GestureAction[] {
    const at = { x: sample.x, y: sample.y };
    const held = this.held.get(sample.id);
    if (!held) return sample.shift && !sample.touch ? [{ kind: "cross", at }] : [];
    const by = { x: at.x - held.at.x, y: at.y - held.at.y };
    if (by.x === 0 && by.y === 0) return [];
    const others = [...this.held].filter(([id]) => id !== sample.id).map(([, other]) => other);
    if (others.length > 0 || this.many) {
      this.held.set(sample.id, { ...held, at });
      return this.together(held.at, at, by, others);
    }
    switch (held.mode) {
      case "cross":
        this.held.set(sample.id, { ...held, at });
        return [{ kind: "cross", at }];
      case "pan":
        this.held.set(sample.id, { ...held, at });
        return [{ kind: "pan", by }];
      case "zoom":
        this.held.set(sample.id, { ...held, at });
        return [{ kind: "zoom", factor: Math.exp(-by.y / 150), at: held.begun }];
      case "tool": {
        if (!held.moved && Math.hypot(at.x - held.begun.x, at.y - held.begun.y) < still) return [];
        this.held.set(sample.id, { ...held, at, moved: true });
        const drag: GestureAction = { kind: "drag", from: held.begun, at, by };
        return held.moved ? [drag] : [{ kind: "begin", at: held.begun }, drag];
      }
    }
  }

  up(id: number, lost = false): readonly GestureAction[] {
    const held = this.held.get(id);
    this.held.delete(id);
    const tapped = held?.mode === "tool" && !held.moved && !this.many && !lost;
    if (this.held.size === 0) this.many = false;
    return tapped ? [{ kind: "tap", at: held.at }] : [];
  }

  private together(before: Point, at: Point, by: Point, others: readonly Held[]): readonly GestureAction[] {
    const other = others[0];
    if (!other) return []; // the last of several fingers, which is about to be lifted
    if (others.length >= 2) {
      this.scrolled += by.y / (others.length + 1);
      const slices = Math.trunc(this.scrolled / scrollEvery);
      this.scrolled -= slices * scrollEvery;
      return slices === 0 ? [] : [{ kind: "scroll", slices }];
    }
    const apartBefore = Math.hypot(before.x - other.at.x, before.y - other.at.y);
    const apart = Math.hypot(at.x - other.at.x, at.y - other.at.y);
    const pan: GestureAction = { kind: "pan", by: { x: by.x / 2, y: by.y / 2 } };
    // Fingers that almost touch would zoom without limit.
    if (apartBefore < 10 || apart < 10) return [pan];
    return [
      pan,
      { kind: "zoom", factor: apart / apartBefore, at: { x: (at.x + other.at.x) / 2, y: (at.y + other.at.y) / 2 } },
    ];
  }
}

/** Pixels of one wheel step. A touchpad reports smaller pieces, which add up to a slice. */
const aClick = 50;
const aSlice = 30;

/** Converts wheel and touchpad movements to slices. The remainder counts towards the next movement. */
export class Wheel {
  private left = 0;

  slices(deltaY: number, deltaMode: number): number {
    if (Math.sign(deltaY) !== Math.sign(this.left)) this.left = 0;
    if (deltaMode !== 0 || Math.abs(deltaY) >= aClick) return Math.sign(deltaY);
    this.left += deltaY;
    const slices = Math.trunc(this.left / aSlice);
    this.left -= slices * aSlice;
    return slices + 0; // avoids negative zero
  }
}
