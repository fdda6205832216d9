import type { RefObject } from "preact";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Icon, type IconName } from "../../icons";
import { windowNames, type WindowName } from "./layout";

const icons: Readonly<Record<WindowName, IconName>> = {
  view: "eye",
  look: "palette",
  light: "lamp",
  lens: "aperture",
  cuts: "slice",
  labels: "tag",
  marks: "pencil",
};

/** Whether there is something to set in a window. Most scans have no labels. */
export const hasWindow = (session: ViewerSession, name: WindowName): boolean =>
  name !== "labels" || session.labels.value.length > 0;

export interface SettingsMenuProps {
  readonly session: ViewerSession;
  readonly leads: boolean;
  readonly shown: readonly WindowName[];
  readonly toggle: (name: WindowName) => void;
  readonly menu: RefObject<HTMLElement | null>;
}

/** The buttons on the left: undo, redo, and one per window. */
export function SettingsMenu({ session, leads, shown, toggle, menu }: SettingsMenuProps) {
  const { editor } = session;
  const { past, future } = editor.steps.value;
  return (
    <nav class="glass menu" aria-label={t.settings.menu} ref={menu}>
      <StepButton icon="undo" possible={leads && past.length > 0} step={() => editor.undo()} />
      <StepButton icon="redo" possible={leads && future.length > 0} step={() => editor.redo()} />
      <hr />
      {windowNames
        .filter((name) => hasWindow(session, name))
        .map((name) => (
          <button
            key={name}
            type="button"
            class="icon-button"
            data-opens={name}
            aria-label={t.settings.windows[name]}
            title={t.settings.windows[name]}
            aria-expanded={shown.includes(name)}
            onClick={() => toggle(name)}
          >
            <Icon name={icons[name]} />
          </button>
        ))}
    </nav>
  );
}

interface StepButtonProps {
  readonly icon: "undo" | "redo";
  readonly possible: boolean;
  readonly step: () => void;
}

/**
 * The button to undo or redo. It is not really disabled, so that it keeps the focus when no step is
 * left.
 */
function StepButton({ icon, possible, step }: StepButtonProps) {
  return (
    <button
      type="button"
      class="icon-button"
      aria-label={t.settings[icon]}
      title={t.settings[icon]}
      aria-keyshortcuts={t.settings.shortcuts[icon]}
      aria-disabled={!possible}
      onClick={() => {
        if (possible) step();
      }}
    >
      <Icon name={icon} />
    </button>
  );
}
