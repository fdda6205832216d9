import { useEffect, useRef } from "preact/hooks";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { focusedOf } from "../../focused";
import type { InPicture } from "../../picture/in_picture";
import { useMedia } from "../../use_media";
import { CutsWindow } from "./cuts_window";
import { LensWindow } from "./lens_window";
import { LightWindow } from "./light_window";
import { MarksWindow } from "../../marks/marks_window";
import { LookWindow } from "./look_window";
import { LabelsWindow } from "../../labels/labels_window";
import { hasWindow, SettingsMenu } from "./settings_menu";
import { SettingsWindow } from "./settings_window";
import { ViewWindow } from "./view_window";
import { useWindowLayout } from "./use_window_layout";

export interface SettingsProps {
  readonly session: ViewerSession;
  /** Whether the user may change the scene. */
  readonly leads: boolean;
  /** Whether the user may also change which parts are cut away. */
  readonly cuts: boolean;
  readonly picture: InPicture;
}

const views = {
  view: ViewWindow,
  look: LookWindow,
  light: LightWindow,
  lens: LensWindow,
  cuts: CutsWindow,
  labels: LabelsWindow,
  marks: MarksWindow,
} as const;
const narrowPage = "(max-width: 700px), (max-height: 420px)";

/** The menu on the left and the windows that it opens (thesis, 4.1 and 5.3). */
export function Settings({ session, leads, cuts, picture }: SettingsProps) {
  const narrow = useMedia(narrowPage);
  const menu = useRef<HTMLElement>(null);
  const { layout, shown, fresh, toggle, close, move, dock } = useWindowLayout(narrow, menu);
  useUndoKeys(session, leads);
  useRoomForTour(session, narrow && shown.includes("view"), () => close("view"));
  useOpenHandles(picture, shown.join(), leads, cuts);
  useMarkEditing(session, shown.includes("marks"));
  return (
    <>
      <SettingsMenu session={session} leads={leads} shown={shown} toggle={toggle} menu={menu} />
      {shown
        .filter((name) => hasWindow(session, name))
        .map((name) => {
          const View = views[name];
          const reset = () => {
            if (name === "marks") session.marks.clear();
            else if (name !== "view") session.reset(name);
          };
          const isReset = name === "view" || (name === "marks" && !hasOwnMarks(session));
          const mayChange = name === "marks" || (leads && (name !== "cuts" || cuts));
          return (
            <SettingsWindow
              key={name}
              name={name}
              layout={layout}
              narrow={narrow}
              fresh={fresh === name}
              onMove={(x, y) => move(name, x, y)}
              onDock={() => dock(name)}
              onClose={() => close(name)}
              onReset={mayChange ? reset : null}
              isReset={isReset}
              disabledReason={leads ? t.settings.notForGuests : t.settings.notYours}
            >
              <View session={session} leads={mayChange} picture={picture} />
            </SettingsWindow>
          );
        })}
    </>
  );
}

const hasOwnMarks = ({ marks }: ViewerSession): boolean => marks.items.value.some((mark) => marks.isOwn(mark));

/** Shows the handles of the open windows in the picture. `openNames` is a string, so that the effect can compare it. */
function useOpenHandles(picture: InPicture, openNames: string, leads: boolean, cuts: boolean): void {
  useEffect(() => {
    const held = cuts ? (["cuts", "light"] as const) : (["light"] as const);
    picture.open.value = leads ? held.filter((name) => openNames.split(",").includes(name)) : [];
  }, [picture, leads, cuts, openNames]);
}

/** Lets marks be changed while their window is open. */
function useMarkEditing({ marks }: ViewerSession, open: boolean): void {
  useEffect(() => {
    marks.editing.value = open;
    if (!open) marks.tool.value = null;
  }, [marks, open]);
}

/** Closes the window that started a tour if it is a sheet, which leaves too little of the picture. */
function useRoomForTour({ guide }: ViewerSession, covered: boolean, close: () => void): void {
  const state = guide.tour.state.value;
  useEffect(() => {
    if (covered && state === "moving") close();
  }, [covered, state]); // eslint-disable-line react-hooks/exhaustive-deps -- once per tour
}

function useUndoKeys(session: ViewerSession, leads: boolean): void {
  useEffect(() => {
    const pressed = (event: KeyboardEvent) => {
      const key = event.key.toLowerCase();
      if (event.defaultPrevented || !(event.ctrlKey || event.metaKey) || event.altKey || !["z", "y"].includes(key))
        return;
      if (focusedOf(event.target) === "text" || document.querySelector("dialog[open]")) return; // a text field has its own undo
      const steps = session.marks.editing.value ? session.marks : leads ? session.editor : null;
      if (!steps) return;
      event.preventDefault();
      if (key === "z" && !event.shiftKey) steps.undo();
      else steps.redo();
    };
    addEventListener("keydown", pressed);
    return () => removeEventListener("keydown", pressed);
  }, [session, leads]);
}
