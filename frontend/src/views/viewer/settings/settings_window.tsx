import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { no_flick } from "../../../input/no_flick";
import { t } from "../../../texts";
import { Icon } from "../../icons";
import { place_in, type Layout, type WindowName } from "./layout";

export interface SettingsWindowProps {
  readonly name: WindowName;
  readonly layout: Layout;
  /** A sheet: it has its place, and cannot be moved. */
  readonly narrow: boolean;
  /** Whether it was just opened by hand: then it takes the focus. */
  readonly fresh: boolean;
  readonly onMove: (x: number, y: number) => void;
  readonly onDock: () => void;
  readonly onClose: () => void;
  readonly onReset: (() => void) | null;
  readonly children: ComponentChildren;
}

const key_step = 24;
const ways: Readonly<Record<string, readonly [number, number]>> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** Settings beside the picture, which stays in reach: no modal dialog. */
export function SettingsWindow({ name, layout, narrow, fresh, onMove, onDock, onClose, onReset, children }: SettingsWindowProps) {
  const frame = useRef<HTMLElement>(null);
  const held = useRef<{ x: number; y: number } | null>(null);
  const place = place_in(layout, name);
  const free = !narrow && !place.docked;
  const title = t.settings.windows[name];
  // Before anything else can be pressed: a later one would take the focus back from where a hand has put it.
  useLayoutEffect(() => {
    if (fresh) frame.current?.focus();
  }, [fresh]);

  const corner = () => frame.current?.getBoundingClientRect() ?? new DOMRect();
  const grabbed = (event: PointerEvent) => {
    const target = event.currentTarget;
    const on_button = event.target instanceof Element && event.target.closest("button") !== null && event.target.closest(".window-grip") === null;
    if (narrow || on_button || event.button !== 0 || !(target instanceof HTMLElement)) return;
    const { x, y } = corner();
    held.current = { x: event.clientX - x, y: event.clientY - y };
    target.setPointerCapture(event.pointerId);
  };
  const dragged = (event: PointerEvent) => {
    if (held.current) onMove(event.clientX - held.current.x, event.clientY - held.current.y);
  };
  const dropped = () => {
    held.current = null;
  };
  const pressed = (event: KeyboardEvent) => {
    const way = ways[event.key];
    if (!way) return;
    event.preventDefault();
    const { x, y } = corner();
    onMove(x + way[0] * key_step, y + way[1] * key_step);
  };
  return (
    <section
      ref={frame}
      class={`glass window${free ? " window-free" : ""}`}
      role="dialog"
      aria-modal="false"
      aria-labelledby={`window-${name}`}
      data-window={name}
      tabIndex={-1}
      {...(free ? { style: { left: `${place.x}px`, top: `${place.y}px` } } : {})}
      onKeyDown={(event) => {
        if (event.key !== "Escape" || event.defaultPrevented) return;
        event.preventDefault();
        onClose();
      }}
    >
      <div class="window-head" onPointerDown={grabbed} onPointerMove={dragged} onPointerUp={dropped} onPointerCancel={dropped} {...(narrow ? {} : { onTouchMove: no_flick })}>
        <h2 id={`window-${name}`}>{title}</h2>
        {narrow ? null : (
          <button type="button" class="icon-button window-grip" aria-label={t.settings.move(title)} title={t.settings.move_help} onKeyDown={pressed}>
            <Icon name="grip" />
          </button>
        )}
        {free ? (
          <button type="button" class="icon-button" aria-label={t.settings.dock(title)} title={t.settings.dock(title)} onClick={onDock}>
            <Icon name="dock" />
          </button>
        ) : null}
        <button type="button" class="icon-button" aria-label={t.settings.close(title)} title={t.settings.close(title)} onClick={onClose}>
          <Icon name="close" />
        </button>
      </div>
      <div class="window-body">
        {onReset ? null : <p class="window-why" role="status">{t.settings.not_yours}</p>}
        <fieldset class="window-controls" disabled={onReset === null}>
          <legend class="visually-hidden">{title}</legend>
          {children}
          <p class="window-foot">
            <button type="button" class="button button-small" onClick={onReset ?? undefined}>{t.settings.reset[name]}</button>
          </p>
        </fieldset>
      </div>
    </section>
  );
}
