import type { Point } from "../input/flat";

/** What hands do in the view of a slice, as plain data. Lengths in CSS pixels. */
export type Deed =
  | { readonly kind: "begin"; readonly at: Point }
  | { readonly kind: "drag"; readonly from: Point; readonly at: Point; readonly by: Point }
  | { readonly kind: "tap"; readonly at: Point }
  | { readonly kind: "cross"; readonly at: Point }
  | { readonly kind: "pan"; readonly by: Point }
  | { readonly kind: "zoom"; readonly factor: number; readonly at: Point }
  | { readonly kind: "scroll"; readonly slices: number };

export interface Touching {
  readonly id: number;
  readonly x: number;
  readonly y: number;
  readonly touch: boolean;
  readonly button: number;
  readonly shift: boolean;
}

type Mode = "tool" | "cross" | "pan" | "zoom";
interface Held {
  readonly mode: Mode;
  readonly begun: Point;
  readonly at: Point;
  readonly moved: boolean;
}

/** Less is a hand that is not quite still. */
const still = 4;
const scroll_every = 12;

/** From pointers to deeds: one finger or the left button is the tool; two fingers move and zoom; three scroll. */
export class SliceHands {
  private readonly held_ = new Map<number, Held>();
  /** More fingers were there: what is left of them is no tool. */
  private many_ = false;
  private scrolled_ = 0;

  down(sample: Touching): readonly Deed[] {
    const mode: Mode = sample.touch ? "tool" : sample.button === 1 ? "pan" : sample.button === 2 ? "zoom" : sample.shift ? "cross" : "tool";
    const at = { x: sample.x, y: sample.y };
    this.held_.set(sample.id, { mode, begun: at, at, moved: false });
    this.many_ = this.held_.size > 1;
    this.scrolled_ = 0;
    return mode === "cross" && !this.many_ ? [{ kind: "cross", at }] : [];
  }

  move(sample: Touching): readonly Deed[] {
    const at = { x: sample.x, y: sample.y };
    const held = this.held_.get(sample.id);
    if (!held) return sample.shift && !sample.touch ? [{ kind: "cross", at }] : [];
    const by = { x: at.x - held.at.x, y: at.y - held.at.y };
    if (by.x === 0 && by.y === 0) return [];
    const others = [...this.held_].filter(([id]) => id !== sample.id).map(([, other]) => other);
    if (others.length > 0 || this.many_) {
      this.held_.set(sample.id, { ...held, at });
      return this.together(held.at, at, by, others);
    }
    switch (held.mode) {
      case "cross":
        this.held_.set(sample.id, { ...held, at });
        return [{ kind: "cross", at }];
      case "pan":
        this.held_.set(sample.id, { ...held, at });
        return [{ kind: "pan", by }];
      case "zoom":
        this.held_.set(sample.id, { ...held, at });
        return [{ kind: "zoom", factor: Math.exp(-by.y / 150), at: held.begun }];
      case "tool": {
        if (!held.moved && Math.hypot(at.x - held.begun.x, at.y - held.begun.y) < still) return [];
        this.held_.set(sample.id, { ...held, at, moved: true });
        const drag: Deed = { kind: "drag", from: held.begun, at, by };
        return held.moved ? [drag] : [{ kind: "begin", at: held.begun }, drag];
      }
    }
  }

  up(id: number, lost = false): readonly Deed[] {
    const held = this.held_.get(id);
    this.held_.delete(id);
    const tapped = held?.mode === "tool" && !held.moved && !this.many_ && !lost;
    if (this.held_.size === 0) this.many_ = false;
    return tapped ? [{ kind: "tap", at: held.at }] : [];
  }

  private together(before: Point, at: Point, by: Point, others: readonly Held[]): readonly Deed[] {
    const other = others[0];
    if (!other) return []; // the last of several fingers: it is about to go
    if (others.length >= 2) {
      this.scrolled_ += by.y / (others.length + 1);
      const slices = Math.trunc(this.scrolled_ / scroll_every);
      this.scrolled_ -= slices * scroll_every;
      return slices === 0 ? [] : [{ kind: "scroll", slices }];
    }
    const apart_before = Math.hypot(before.x - other.at.x, before.y - other.at.y);
    const apart = Math.hypot(at.x - other.at.x, at.y - other.at.y);
    const pan: Deed = { kind: "pan", by: { x: by.x / 2, y: by.y / 2 } };
    // Fingers almost upon each other would zoom without measure.
    if (apart_before < 10 || apart < 10) return [pan];
    return [pan, { kind: "zoom", factor: apart / apart_before, at: { x: (at.x + other.at.x) / 2, y: (at.y + other.at.y) / 2 } }];
  }
}

/** Pixels that a wheel tells at once, and that a touchpad tells bit by bit. */
const a_click = 50;
const a_slice = 30;

/** A wheel, or a touchpad, in slices: what is less than one is kept for the next turn. */
export class Wheel {
  private left_ = 0;

  slices(delta_y: number, delta_mode: number): number {
    if (Math.sign(delta_y) !== Math.sign(this.left_)) this.left_ = 0;
    if (delta_mode !== 0 || Math.abs(delta_y) >= a_click) return Math.sign(delta_y);
    this.left_ += delta_y;
    const slices = Math.trunc(this.left_ / a_slice);
    this.left_ -= slices * a_slice;
    return slices + 0; // no negative zero
  }
}
