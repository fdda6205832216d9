import type { RefObject } from "preact";
import { useEffect, useState } from "preact/hooks";

interface AnnouncerProps {
  readonly of: RefObject<HTMLElement | null>;
}

/**
 * Lets screen readers announce the texts with the attribute `data-said` inside an element, but not the buttons beside
 * them. A live region must be there before its text, and a button in one would be read with every change.
 */
export function Announcer({ of }: AnnouncerProps) {
  const [said, setSaid] = useState<readonly string[]>([]);
  useEffect(() => {
    const element = of.current;
    if (!element) return;
    const read = () => {
      const texts = [...element.querySelectorAll("[data-said]")].map((one) => one.textContent.trim());
      setSaid((before) => (before.join("\n") === texts.join("\n") ? before : texts));
    };
    const observer = new MutationObserver(read);
    observer.observe(element, { childList: true, subtree: true, characterData: true });
    read();
    return () => observer.disconnect();
  }, [of]);
  return (
    <p class="visually-hidden" role="status">
      {said.map((text) => (
        <span key={text}>{text} </span>
      ))}
    </p>
  );
}
