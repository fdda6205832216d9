import type { Area, Point } from "./flat";
import type { PointerSample } from "./pointer_sample";

/** A gesture as plain data. Lengths are fractions of the picture's height, and angles are in radians. */
export type Gesture =
  | { readonly kind: "rotate"; readonly right: number; readonly down: number }
  | { readonly kind: "pan"; readonly right: number; readonly down: number }
  | { readonly kind: "zoom"; readonly factor: number }
  | { readonly kind: "roll"; readonly angle: number };

type Mode = "rotate" | "pan" | "zoom" | "roll";

interface Held {
  readonly touch: boolean;
  readonly mode: Mode;
  readonly x: number;
  readonly y: number;
}

/** Translates pointer events into gestures as the viewer's help describes them. Independent of the page. */
export class Gestures {
  private readonly held = new Map<number, Held>();

  get active(): boolean {
    return this.held.size > 0;
  }

  down(sample: PointerSample): void {
    this.held.set(sample.id, { touch: sample.touch, mode: modeOf(sample), x: sample.x, y: sample.y });
  }

  up(id: number): void {
    this.held.delete(id);
  }

  move(sample: PointerSample, area: Area): Gesture[] {
    const held = this.held.get(sample.id);
    if (!held || area.height <= 0) return [];
    if (sample.x === held.x && sample.y === held.y) return []; // reported already
    const others = [...this.held].filter(([id, other]) => id !== sample.id && other.touch).map(([, other]) => other);
    const now: Held = { ...held, x: sample.x, y: sample.y };
    this.held.set(sample.id, now);
    const other = others[0];
    if (held.touch && other) return others.length === 1 ? twoFingers(held, now, other, area) : [];
    return one(held, now, area);
  }
}

function modeOf(sample: PointerSample): Mode {
  if (sample.touch) return "rotate";
  if (sample.button === 1 || (sample.button === 0 && sample.shift)) return "pan";
  if (sample.button === 2) return "zoom";
  return sample.ctrl ? "roll" : "rotate";
}

function one(before: Held, now: Held, area: Area): Gesture[] {
  const right = (now.x - before.x) / area.height;
  const down = (now.y - before.y) / area.height;
  switch (before.mode) {
    case "rotate": // the height of the picture is half a turn
      return [{ kind: "rotate", right: right * Math.PI, down: down * Math.PI }];
    case "pan":
      return [{ kind: "pan", right, down }];
    case "zoom":
      return [{ kind: "zoom", factor: Math.exp(-3 * down) }];
    case "roll": {
      const turn = angleAboutMiddle(now, area) - angleAboutMiddle(before, area);
      return [{ kind: "roll", angle: turn - 2 * Math.PI * Math.round(turn / (2 * Math.PI)) }];
    }
  }
}

/** Returns the angle of a point about the middle, clockwise because y points down. */
const angleAboutMiddle = (at: Point, area: Area): number => Math.atan2(at.y - area.height / 2, at.x - area.width / 2);

/** Returns the gestures of a finger that moves while another rests: the picture pans and zooms. */
function twoFingers(before: Held, now: Held, other: Held, area: Area): Gesture[] {
  const apartBefore = Math.hypot(before.x - other.x, before.y - other.y);
  const apartNow = Math.hypot(now.x - other.x, now.y - other.y);
  const gestures: Gesture[] = [
    { kind: "pan", right: (now.x - before.x) / 2 / area.height, down: (now.y - before.y) / 2 / area.height },
  ];
  // Fingers that almost touch would zoom without limit.
  if (apartBefore > 10 && apartNow > 10) gestures.push({ kind: "zoom", factor: apartNow / apartBefore });
  return gestures;
}

/**
 * Returns the zoom factor of a wheel event. `deltaMode` is that of WheelEvent: 0 pixels, 1 lines, 2
 * pages. A pinch on a touchpad arrives as a wheel event with Ctrl.
 */
export function wheelZoom(deltaY: number, deltaMode: number, pinch: boolean): number {
  const pixels = deltaY * (deltaMode === 1 ? 16 : deltaMode === 2 ? 400 : 1);
  const bounded = Math.max(-300, Math.min(300, pixels));
  return Math.exp(-bounded * (pinch ? 0.01 : 0.0015));
}
