import { useEffect, useState } from "preact/hooks";
import { local } from "../../storage";
import { t } from "../../texts";
import { Icon } from "../icons";
import { touchScreen, useMedia } from "../use_media";
import { hintsDue, hintsSeen } from "./hint_memory";

/** Three tips on first use, one after the other. Escape closes them from anywhere on the page. */
export function Hints({ onDone }: { readonly onDone: () => void }) {
  const [at, setAt] = useState(() => (hintsDue(local) ? 0 : -1));
  const touch = useMedia(touchScreen);
  const text = t.viewer.hints;
  const end = () => {
    hintsSeen(local);
    setAt(-1);
    onDone();
  };
  useEffect(() => {
    if (at < 0) return;
    const pressed = (event: KeyboardEvent) => {
      if (event.key !== "Escape" || event.defaultPrevented || document.querySelector("dialog[open]")) return;
      event.preventDefault();
      hintsSeen(local);
      setAt(-1);
    };
    addEventListener("keydown", pressed);
    return () => removeEventListener("keydown", pressed);
  }, [at]);
  const hint = at === 0 && touch ? text.touch : text.all[at];
  if (hint === undefined) return null;
  const last = at === text.all.length - 1;
  return (
    <aside class="glass hints" aria-label={text.title(at + 1, text.all.length)}>
      <p aria-live="polite">{hint}</p>
      <button type="button" class="button button-small" onClick={() => (last ? end() : setAt(at + 1))}>
        {last ? text.done : text.next}
      </button>
      <button type="button" class="icon-button" aria-label={text.hide} title={text.hide} onClick={end}>
        <Icon name="close" />
      </button>
    </aside>
  );
}
