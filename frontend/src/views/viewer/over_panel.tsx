import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { Icon } from "../icons";

export interface OverPanelProps {
  readonly heading: string;
  /** What happened, as paragraphs. */
  readonly text: ComponentChildren;
  /** The links and buttons with which the viewer continues. */
  readonly children: ComponentChildren;
}

/** Replaces the picture when the viewer's time is over. Takes the focus, so that a screen reader reads it. */
export function OverPanel({ heading, text, children }: OverPanelProps) {
  const focused = useRef<HTMLHeadingElement>(null);
  useEffect(() => focused.current?.focus(), []);
  return (
    <section class="glass time-over" aria-labelledby="time-over">
      <Icon name="clock" />
      <h2 id="time-over" ref={focused} tabIndex={-1}>
        {heading}
      </h2>
      {text}
      <p class="time-over-ways">{children}</p>
    </section>
  );
}
