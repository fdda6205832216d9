import { useEffect, useRef, useState } from "preact/hooks";
import { tab } from "../../../storage";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { focused_of } from "../../focused";
import { Icon, type IconName } from "../../icons";
import type { InPicture } from "../../picture/in_picture";
import { use_media } from "../../use_media";
import { CutsWindow } from "./cuts_window";
import { closed, docked, moved, opened, remember_layout, remembered_layout, window_names, type Layout, type WindowName } from "./layout";
import { LensWindow } from "./lens_window";
import { LightWindow } from "./light_window";
import { LookWindow } from "./look_window";
import { SettingsWindow } from "./settings_window";

export interface SettingsProps {
  readonly session: ViewerSession;
  /** The scene is this person's to change. */
  readonly leads: boolean;
  /** So is what is cut away of the scan. */
  readonly cuts: boolean;
  readonly picture: InPicture;
}

const icons: Readonly<Record<WindowName, IconName>> = { look: "palette", light: "lamp", lens: "aperture", cuts: "slice" };
const views = { look: LookWindow, light: LightWindow, lens: LensWindow, cuts: CutsWindow } as const;
const narrow_page = "(max-width: 700px), (max-height: 420px)";

/** The menu at the left, and the windows that it opens (thesis, 4.1 and 5.3). */
export function Settings({ session, leads, cuts, picture }: SettingsProps) {
  const [layout, set_layout] = useState<Layout>(() => remembered_layout(tab));
  const [fresh, set_fresh] = useState<WindowName | null>(null);
  const narrow = use_media(narrow_page);
  const menu = useRef<HTMLElement>(null);
  const steps = session.steps.value;

  const change = (next: Layout) => {
    set_layout(next);
    remember_layout(tab, next);
  };
  const show = (name: WindowName) => {
    set_fresh(name);
    change(opened(layout, name, narrow));
  };
  const close = (name: WindowName) => {
    set_fresh(null);
    change(closed(layout, name));
    menu.current?.querySelector<HTMLElement>(`[data-opens="${name}"]`)?.focus();
  };
  use_undo_keys(session, leads);
  const shown = narrow ? layout.open.slice(-1) : layout.open;
  const open_names = shown.join();
  useEffect(() => {
    const held = cuts ? (["cuts", "light"] as const) : (["light"] as const);
    picture.open.value = leads ? held.filter((name) => open_names.split(",").includes(name)) : [];
  }, [picture, leads, cuts, open_names]);
  const step_button = (icon: "undo" | "redo", way: () => void, possible: boolean) => (
    <button type="button" class="icon-button" aria-label={t.settings[icon]} title={t.settings[icon]} aria-keyshortcuts={t.settings.shortcuts[icon]}
      aria-disabled={!possible} onClick={() => {
        if (possible) way();
      }}>
      <Icon name={icon} />
    </button>
  );
  return (
    <>
      <nav class="glass menu" aria-label={t.settings.menu} ref={menu}>
        {step_button("undo", () => session.undo(), leads && steps.past.length > 0)}
        {step_button("redo", () => session.redo(), leads && steps.future.length > 0)}
        <hr />
        {window_names.map((name) => (
          <button key={name} type="button" class="icon-button" data-opens={name} aria-label={t.settings.windows[name]} title={t.settings.windows[name]}
            aria-expanded={shown.includes(name)} onClick={() => (shown.includes(name) ? close(name) : show(name))}>
            <Icon name={icons[name]} />
          </button>
        ))}
      </nav>
      {shown.map((name) => {
        const View = views[name];
        const may_change = leads && (name !== "cuts" || cuts);
        return (
          <SettingsWindow key={name} name={name} layout={layout} narrow={narrow} fresh={fresh === name}
            onMove={(x, y) => change(moved(layout, name, x, y, { width: innerWidth, height: innerHeight }))}
            onDock={() => change(docked(layout, name))} onClose={() => close(name)} onReset={may_change ? () => session.reset(name) : null}>
            <View session={session} leads={may_change} picture={picture} />
          </SettingsWindow>
        );
      })}
    </>
  );
}

function use_undo_keys(session: ViewerSession, leads: boolean): void {
  useEffect(() => {
    const pressed = (event: KeyboardEvent) => {
      const key = event.key.toLowerCase();
      if (!leads || event.defaultPrevented || !(event.ctrlKey || event.metaKey) || event.altKey || !["z", "y"].includes(key)) return;
      if (focused_of(event.target) === "text" || document.querySelector("dialog[open]")) return; // text has an undo of its own
      event.preventDefault();
      if (key === "z" && !event.shiftKey) session.undo();
      else session.redo();
    };
    addEventListener("keydown", pressed);
    return () => removeEventListener("keydown", pressed);
  }, [session, leads]);
}
