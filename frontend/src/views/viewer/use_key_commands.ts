import { useEffect } from "preact/hooks";
import { commandOf, type KeyCommand } from "../../input/keys";
import { focusedOf } from "../focused";
import { useLatest } from "../use_latest";

/** Runs `obey` for the keys of the viewer, wherever the focus is, unless a dialog is open or it is not `active`. */
export function useKeyCommands(obey: (command: KeyCommand) => void, active = true): void {
  const latest = useLatest(obey);
  useEffect(() => {
    if (!active) return;
    const pressed = (event: KeyboardEvent) => {
      if (event.defaultPrevented || document.querySelector("dialog[open]")) return;
      const command = commandOf(
        { key: event.key, shift: event.shiftKey, ctrl: event.ctrlKey, alt: event.altKey, meta: event.metaKey },
        focusedOf(event.target),
      );
      if (!command) return;
      event.preventDefault();
      // Holding a key that switches something must not switch it back and forth.
      if (event.repeat && ["tour", "pause", "play"].includes(command.kind)) return;
      latest.current(command);
    };
    addEventListener("keydown", pressed);
    return () => removeEventListener("keydown", pressed);
  }, [latest, active]);
}
