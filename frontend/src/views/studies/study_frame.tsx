import type { ComponentChildren } from "preact";
import { t } from "../../texts";
import { Mark } from "../icons";
import { LanguageChoice, SkipLink, ThemeSwitch } from "../shell";

export interface StudyFrameProps {
  /** Whether the page fills the window, for a step with a picture. */
  readonly filled?: boolean;
  /** Buttons at the top. */
  readonly tools?: ComponentChildren;
  readonly children: ComponentChildren;
}

/** The frame of a participant's pages. It leads to no other page of the product. */
export function StudyFrame({ filled = false, tools, children }: StudyFrameProps) {
  return (
    <div class={filled ? "study study-filled" : "study"}>
      <SkipLink />
      <header class="study-bar">
        <span class="brand">
          <Mark />
          <span>{t.name}</span>
        </span>
        <div class="bar-end">
          <LanguageChoice />
          <ThemeSwitch />
          {tools}
        </div>
      </header>
      <main id="content" tabIndex={-1} class="study-main">
        {children}
      </main>
      <footer class="study-foot">{t.viewer.notMedical}</footer>
    </div>
  );
}

/** A page of a participant with a text and no task. */
export function StudyMessage({ children }: { readonly children: ComponentChildren }) {
  return (
    <StudyFrame>
      <div class="page page-narrow">{children}</div>
    </StudyFrame>
  );
}

/** A text of the researcher, in paragraphs. It may be in another language than the page. */
export function Paragraphs({ text, lang }: { readonly text: string; readonly lang: string }) {
  return (
    <div class="study-text" lang={lang}>
      {text
        .split(/\n\s*\n/)
        .filter((part) => part.trim() !== "")
        .map((part, i) => (
          <p key={i}>{part}</p>
        ))}
    </div>
  );
}
