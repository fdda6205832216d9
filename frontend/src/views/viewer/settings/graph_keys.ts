import type { PointActs } from "./point_controls";

/** The action of a key on the chosen point of the graph. */
export type GraphKeyAction =
  | { readonly kind: "choose"; readonly by: number }
  | { readonly kind: "move"; readonly value: number; readonly opacity: number }
  | { readonly kind: "add" }
  | { readonly kind: "remove" };

export type KeyStroke = Pick<KeyboardEvent, "key" | "shiftKey" | "ctrlKey" | "metaKey" | "altKey">;

/**
 * Returns the action of a key. `width` is the range of the shown values. Shift makes the steps ten
 * times as long.
 */
export function graphKeyAction(stroke: KeyStroke, width: number): GraphKeyAction | null {
  if (stroke.ctrlKey || stroke.metaKey || stroke.altKey) return null;
  const value = Math.max(1, Math.round(width / (stroke.shiftKey ? 20 : 200)));
  const opacity = stroke.shiftKey ? 0.1 : 0.01;
  switch (stroke.key) {
    case "PageDown":
      return { kind: "choose", by: 1 };
    case "PageUp":
      return { kind: "choose", by: -1 };
    case "ArrowLeft":
      return { kind: "move", value: -value, opacity: 0 };
    case "ArrowRight":
      return { kind: "move", value, opacity: 0 };
    case "ArrowUp":
      return { kind: "move", value: 0, opacity };
    case "ArrowDown":
      return { kind: "move", value: 0, opacity: -opacity };
    case "Insert":
      return { kind: "add" };
    case "Delete":
      return { kind: "remove" };
    default:
      return null;
  }
}

export interface GraphActs extends PointActs {
  /** Adds a point at `at`, or by default where there is most room. */
  readonly add: (at?: { readonly value: number; readonly opacity: number }) => void;
}

/** Applies a key's action to the chosen point. `count` is the number of points. */
export function applyGraphKey(
  action: GraphKeyAction,
  chosen: { readonly value: number; readonly opacity: number },
  count: number,
  acts: GraphActs,
): void {
  switch (action.kind) {
    case "choose":
      acts.choose(Math.min(count - 1, Math.max(0, acts.point + action.by)));
      break;
    case "move":
      acts.move(acts.point, chosen.value + action.value, chosen.opacity + action.opacity, false);
      break;
    case "add":
      acts.add();
      break;
    case "remove":
      acts.remove();
      break;
  }
}
