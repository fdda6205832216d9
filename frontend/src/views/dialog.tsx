import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef } from "preact/hooks";
import { t } from "../texts";
import { focusTitle } from "./shell";

export interface DialogProps {
  readonly title: string;
  readonly onClose: () => void;
  readonly children: ComponentChildren;
}

/** A modal dialog. The browser keeps the focus inside, closes it on Escape and then restores the focus. */
export function Dialog({ title, onClose, children }: DialogProps) {
  const dialog = useRef<HTMLDialogElement>(null);
  const heading = useRef<HTMLHeadingElement>(null);
  const titleId = useId(); // one dialog may be opened from another
  useEffect(() => {
    const element = dialog.current;
    const before = document.activeElement;
    element?.showModal();
    // The browser focuses the first control. If that has scrolled the beginning away, reading starts at the heading.
    if (element && element.scrollTop > 0) heading.current?.focus();
    return () => {
      element?.close();
      if (before instanceof HTMLElement && before.isConnected) before.focus();
      else focusTitle();
    };
  }, []);
  return (
    <dialog
      ref={dialog}
      aria-labelledby={titleId}
      onCancel={(event) => {
        event.preventDefault();
        onClose();
      }}
      onClick={(event) => {
        if (event.target === dialog.current) onClose();
      }}
    >
      <div class="dialog-body">
        <h2 id={titleId} ref={heading} tabIndex={-1}>
          {title}
        </h2>
        {children}
      </div>
    </dialog>
  );
}

/** The only button of a dialog that has nothing to confirm. */
export function CloseButton({ onClick }: { readonly onClick: () => void }) {
  return (
    <div class="dialog-buttons">
      <button type="button" class="button button-main" onClick={onClick}>
        {t.close}
      </button>
    </div>
  );
}

/** The button of a dialog whose form has the button that confirms, or whose choices confirm. */
export function CancelButton({ onClick }: { readonly onClick: () => void }) {
  return (
    <div class="dialog-buttons">
      <button type="button" class="button" onClick={onClick}>
        {t.cancel}
      </button>
    </div>
  );
}
