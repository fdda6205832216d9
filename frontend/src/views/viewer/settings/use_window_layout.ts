import type { RefObject } from "preact";
import { useState } from "preact/hooks";
import { tab } from "../../../storage";
import {
  closed,
  docked,
  moved,
  opened,
  rememberLayout,
  rememberedLayout,
  type Layout,
  type WindowName,
} from "./layout";

export interface WindowLayout {
  readonly layout: Layout;
  /** The open windows that are shown. A narrow page shows only the last one opened. */
  readonly shown: readonly WindowName[];
  /** The window that the user just opened, which takes the focus. */
  readonly fresh: WindowName | null;
  readonly toggle: (name: WindowName) => void;
  readonly close: (name: WindowName) => void;
  readonly move: (name: WindowName, x: number, y: number) => void;
  readonly dock: (name: WindowName) => void;
}

/**
 * The open settings windows and their places, which this tab remembers. Closing a window focuses
 * its button in `menu`.
 */
export function useWindowLayout(narrow: boolean, menu: RefObject<HTMLElement | null>): WindowLayout {
  const [layout, setLayout] = useState<Layout>(() => rememberedLayout(tab));
  const [fresh, setFresh] = useState<WindowName | null>(null);
  const shown = narrow ? layout.open.slice(-1) : layout.open;
  const change = (next: Layout) => {
    setLayout(next);
    rememberLayout(tab, next);
  };
  const show = (name: WindowName) => {
    setFresh(name);
    change(opened(layout, name, narrow));
  };
  const close = (name: WindowName) => {
    setFresh(null);
    change(closed(layout, name));
    menu.current?.querySelector<HTMLElement>(`[data-opens="${name}"]`)?.focus();
  };
  return {
    layout,
    shown,
    fresh,
    toggle: (name) => (shown.includes(name) ? close(name) : show(name)),
    close,
    move: (name, x, y) => change(moved(layout, name, x, y, { width: innerWidth, height: innerHeight })),
    dock: (name) => change(docked(layout, name)),
  };
}
