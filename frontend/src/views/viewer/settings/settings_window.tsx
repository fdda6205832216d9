import type { ComponentChildren } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import { noFlick } from "../../../input/no_flick";
import { t } from "../../../texts";
import { Icon } from "../../icons";
import { IconButton } from "../../icon_button";
import { placeIn, type Layout, type WindowName } from "./layout";
import { useWindowDrag, type WindowDrag } from "./use_window_drag";

export interface SettingsWindowProps {
  readonly name: WindowName;
  readonly layout: Layout;
  /** Whether the page is narrow, so that the window is a sheet with a fixed place. */
  readonly narrow: boolean;
  /** Whether the user just opened the window, so that it takes the focus. */
  readonly fresh: boolean;
  readonly onMove: (x: number, y: number) => void;
  readonly onDock: () => void;
  readonly onClose: () => void;
  readonly onReset: (() => void) | null;
  /** Whether there is nothing to reset. */
  readonly isReset: boolean;
  /** Why the user can change nothing here, if `onReset` is null. */
  readonly disabledReason: string;
  readonly children: ComponentChildren;
}

/** A settings window next to the picture. It is not modal, so the picture stays usable. */
export function SettingsWindow(props: SettingsWindowProps) {
  const { name, layout, narrow, fresh, onMove, onClose } = props;
  const frame = useRef<HTMLElement>(null);
  const drag = useWindowDrag(frame, narrow, onMove);
  const place = placeIn(layout, name);
  const free = !narrow && !place.docked;
  // A layout effect runs before the next input. A later effect could take the focus from a newer choice.
  useLayoutEffect(() => {
    if (fresh) frame.current?.focus();
  }, [fresh]);
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
      <WindowHead {...props} drag={drag} free={free} />
      <WindowBody {...props} />
    </section>
  );
}

interface WindowHeadProps extends SettingsWindowProps {
  readonly drag: WindowDrag;
  /** Whether the window was moved out of the dock. */
  readonly free: boolean;
}

function WindowHead({ name, narrow, drag, free, onDock, onClose }: WindowHeadProps) {
  const title = t.settings.windows[name];
  return (
    <div
      class="window-head"
      onPointerDown={drag.grab}
      onPointerMove={drag.move}
      onPointerUp={drag.drop}
      onPointerCancel={drag.drop}
      {...(narrow ? {} : { onTouchMove: noFlick })}
    >
      <h2 id={`window-${name}`}>{title}</h2>
      {narrow ? null : (
        <button
          type="button"
          class="icon-button window-grip"
          aria-label={t.settings.move(title)}
          title={t.settings.moveHelp}
          onKeyDown={drag.key}
        >
          <Icon name="grip" />
        </button>
      )}
      {free ? <IconButton icon="dock" label={t.settings.dock(title)} onClick={onDock} /> : null}
      <IconButton icon="close" label={t.settings.close(title)} onClick={onClose} />
    </div>
  );
}

function WindowBody({ name, onReset, isReset, disabledReason, children }: SettingsWindowProps) {
  return (
    <div class="window-body">
      {onReset ? null : (
        <p class="window-why" role="status">
          {disabledReason}
        </p>
      )}
      <fieldset class="window-controls" disabled={onReset === null}>
        <legend class="visually-hidden">{t.settings.windows[name]}</legend>
        {children}
        {isReset ? null : (
          <p class="window-foot">
            <button type="button" class="button button-small" onClick={onReset ?? undefined}>
              {t.settings.reset[name]}
            </button>
          </p>
        )}
      </fieldset>
    </div>
  );
}
