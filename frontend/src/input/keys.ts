import { standardSides } from "./cube";
import type { Gesture } from "./gestures";

export type KeyCommand =
  | { readonly kind: "gesture"; readonly gesture: Gesture }
  | { readonly kind: "reset" }
  /** A standard view, by the letter of the orientation cube. */
  | { readonly kind: "side"; readonly letter: string }
  | { readonly kind: "tour" }
  | { readonly kind: "pause" }
  /** Plays the phases of the scan, or pauses. */
  | { readonly kind: "play" }
  | { readonly kind: "phase"; readonly by: 1 | -1 }
  | { readonly kind: "preset"; readonly index: number }
  | { readonly kind: "fullscreen" }
  | { readonly kind: "screenshot" }
  | { readonly kind: "help" }
  | { readonly kind: "slices" }
  | { readonly kind: "alone" };

/** The kind of element that has the focus. Text and lists use letters, and a slider or a checkbox uses arrows only. */
export type Focused = "text" | "list" | "choice" | "none";

export interface KeyPress {
  readonly key: string;
  readonly shift: boolean;
  readonly ctrl: boolean;
  readonly alt: boolean;
  readonly meta: boolean;
}

/** The number keys from 1 to this one choose a look. */
export const mostLookKeys = 7;

const step = (5 * Math.PI) / 180;
const zoomStep = 1.12;

/**
 * Returns the command of a key press, or null for keys that belong to the browser or to the focused
 * element. Arrow keys rotate, with Shift they pan, and with Ctrl left and right roll, so every drag
 * has a key. Shift and a letter of the orientation cube turn to that side.
 */
export function commandOf(press: KeyPress, focused: Focused): KeyCommand | null {
  if (press.alt || press.meta || focused === "text" || focused === "list") return null;
  const view = press.ctrl ? undefined : views[press.key.toLowerCase()];
  if (view || focused === "choice") return view ?? null;
  const arrow = arrows[press.key];
  if (arrow) return arrowCommand(arrow, press);
  if (press.ctrl) return null;
  const letter = press.shift ? press.key.toUpperCase() : "";
  if ((standardSides as readonly string[]).includes(letter)) return { kind: "side", letter };
  switch (press.key) {
    case "+":
    case "=":
      return { kind: "gesture", gesture: { kind: "zoom", factor: zoomStep } };
    case "-":
    case "_":
      return { kind: "gesture", gesture: { kind: "zoom", factor: 1 / zoomStep } };
    case "r":
    case "R":
      return { kind: "reset" };
    case "t":
    case "T":
      return { kind: "tour" };
    case "p":
    case "P":
      return { kind: "pause" };
    case "f":
    case "F":
      return { kind: "fullscreen" };
    case "s":
    case "S":
      return { kind: "screenshot" };
    case "?":
      return { kind: "help" };
    default:
      return /^[1-9]$/.test(press.key) && Number(press.key) <= mostLookKeys
        ? { kind: "preset", index: Number(press.key) - 1 }
        : null;
  }
}

/**
 * Commands that also work while a tool of the slices or a slider has the focus, because it keeps it.
 */
const views: Readonly<Record<string, KeyCommand>> = {
  v: { kind: "slices" },
  m: { kind: "alone" },
  k: { kind: "play" },
  ",": { kind: "phase", by: -1 },
  ".": { kind: "phase", by: 1 },
};

const arrows: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

function arrowCommand([right, down]: readonly [number, number], press: KeyPress): KeyCommand | null {
  if (press.ctrl) return right === 0 ? null : { kind: "gesture", gesture: { kind: "roll", angle: right * step } };
  if (press.shift) return { kind: "gesture", gesture: { kind: "pan", right: right * 0.03, down: down * 0.03 } };
  return { kind: "gesture", gesture: { kind: "rotate", right: right * step, down: down * step } };
}
