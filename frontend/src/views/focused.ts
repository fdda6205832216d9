import type { Focused } from "../input/keys";

const choices: readonly string[] = ["range", "checkbox", "radio", "color", "button", "file"];

/** Returns the kind of element on which a key was pressed. */
export function focusedOf(target: EventTarget | null): Focused {
  if (!(target instanceof HTMLElement)) return "none";
  if (target instanceof HTMLSelectElement) return "list";
  if (target instanceof HTMLInputElement) return choices.includes(target.type) ? "choice" : "text";
  return target instanceof HTMLTextAreaElement || target.isContentEditable ? "text" : "none";
}
