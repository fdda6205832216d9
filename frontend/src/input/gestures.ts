import type { Area, Point } from "./flat";

/** What a hand does, as plain data. Lengths are parts of the picture's height, angles radians. */
export type Gesture =
  | { readonly kind: "rotate"; readonly right: number; readonly down: number }
  | { readonly kind: "pan"; readonly right: number; readonly down: number }
  | { readonly kind: "zoom"; readonly factor: number }
  | { readonly kind: "roll"; readonly angle: number };

/** A pointer event, as much of it as counts. Positions in CSS pixels from the picture's corner. */
export interface PointerSample {
  readonly id: number;
  readonly x: number;
  readonly y: number;
  readonly touch: boolean;
  readonly button: number;
  readonly shift: boolean;
  readonly ctrl: boolean;
}

type Mode = "rotate" | "pan" | "zoom" | "roll";

interface Held {
  readonly touch: boolean;
  readonly mode: Mode;
  readonly x: number;
  readonly y: number;
}

/** From pointers to gestures, by the table of the viewer's conventions. Knows nothing of the page. */
export class Gestures {
  private readonly held_ = new Map<number, Held>();

  get active(): boolean {
    return this.held_.size > 0;
  }

  down(sample: PointerSample): void {
    this.held_.set(sample.id, { touch: sample.touch, mode: mode_of(sample), x: sample.x, y: sample.y });
  }

  up(id: number): void {
    this.held_.delete(id);
  }

  move(sample: PointerSample, area: Area): Gesture[] {
    const held = this.held_.get(sample.id);
    if (!held || area.height <= 0) return [];
    if (sample.x === held.x && sample.y === held.y) return []; // told already, and a new scene would begin a new picture
    const others = [...this.held_].filter(([id, other]) => id !== sample.id && other.touch).map(([, other]) => other);
    const now: Held = { ...held, x: sample.x, y: sample.y };
    this.held_.set(sample.id, now);
    const other = others[0];
    if (held.touch && other) return others.length === 1 ? two_fingers(held, now, other, area) : [];
    return one(held, now, area);
  }
}

function mode_of(sample: PointerSample): Mode {
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
      const turn = angle_about_middle(now, area) - angle_about_middle(before, area);
      return [{ kind: "roll", angle: turn - 2 * Math.PI * Math.round(turn / (2 * Math.PI)) }];
    }
  }
}

/** Clockwise, as y goes down. */
const angle_about_middle = (at: Point, area: Area): number =>
  Math.atan2(at.y - area.height / 2, at.x - area.width / 2);

/** One finger moved while another rests: what lies between the two moves and grows with them. */
function two_fingers(before: Held, now: Held, other: Held, area: Area): Gesture[] {
  const apart_before = Math.hypot(before.x - other.x, before.y - other.y);
  const apart_now = Math.hypot(now.x - other.x, now.y - other.y);
  const gestures: Gesture[] = [
    { kind: "pan", right: (now.x - before.x) / 2 / area.height, down: (now.y - before.y) / 2 / area.height },
  ];
  // Fingers almost upon each other would zoom without measure.
  if (apart_before > 10 && apart_now > 10) gestures.push({ kind: "zoom", factor: apart_now / apart_before });
  return gestures;
}

/** `delta_mode` as in WheelEvent: 0 pixels, 1 lines, 2 pages. A pinch on a touchpad comes as a wheel with Ctrl. */
export function wheel_zoom(delta_y: number, delta_mode: number, pinch: boolean): number {
  const pixels = delta_y * (delta_mode === 1 ? 16 : delta_mode === 2 ? 400 : 1);
  const bounded = Math.max(-300, Math.min(300, pixels));
  return Math.exp(-bounded * (pinch ? 0.01 : 0.0015));
}
