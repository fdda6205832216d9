import type { ComponentChildren } from "preact";
import { t } from "../../texts";
import { IconButton } from "../icon_button";
import { Icon } from "../icons";
import { Link, navigate } from "../router";
import { comparePath } from "../routes";
import { ThemeSwitch } from "../shell";

export interface CompareHeaderProps {
  readonly title: string;
  readonly first: string;
  readonly second: string;
  /** Whether one scan is to be shown over the other. */
  readonly over?: boolean;
  /** The tools of this way to compare. */
  readonly children: ComponentChildren;
}

/** The title and the tools of the page that shows two scans side by side. */
export function CompareHeader({ title, first, second, over = false, children }: CompareHeaderProps) {
  return (
    <header class="compare-top">
      <div class="compare-title">
        <Link href="/scans" class="icon-button" label={t.viewer.back}>
          <Icon name="back" />
        </Link>
        <h1>{title}</h1>
      </div>
      <div class="compare-tools">
        <CompareModes first={first} second={second} over={over} />
        {children}
        <IconButton
          class="tool-swap"
          icon="swap"
          label={t.compare.swap}
          onClick={() => navigate(comparePath(second, first, over), true)}
        />
        <ThemeSwitch />
      </div>
    </header>
  );
}

/** The two ways to show two scans. */
export function CompareModes({ first, second, over }: { first: string; second: string; over: boolean }) {
  return (
    <nav class="compare-modes" aria-label={t.compare.ways}>
      <Link href={comparePath(first, second)} class="button button-small" current={!over}>
        {t.compare.modes.side}
      </Link>
      <Link href={comparePath(first, second, true)} class="button button-small" current={over}>
        {t.compare.modes.over}
      </Link>
    </nav>
  );
}
