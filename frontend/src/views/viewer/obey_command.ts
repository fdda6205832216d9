import type { KeyCommand } from "../../input/keys";
import { isVisitOver } from "../../protocol/connection";
import type { ViewerSession } from "../../video/viewer_session";
import { maximiseFocused, toggleSlices } from "./slices/slice_views";
import type { OpenDialog } from "./viewer_dialogs";

export interface CommandTargets {
  readonly session: ViewerSession;
  /** The element that is shown in full screen. */
  readonly page: HTMLElement | null;
  /** Whether slices are offered, which they are not while the scan is being cut. */
  readonly slices: boolean;
  readonly open: (dialog: OpenDialog) => void;
}

/** Executes a command of the keyboard or of the toolbar. */
export function obeyCommand(command: KeyCommand, { session, page, slices, open }: CommandTargets): void {
  if (isVisitOver(session.connection.value) && command.kind !== "help" && command.kind !== "fullscreen") return;
  switch (command.kind) {
    case "gesture":
      session.editor.act(command.gesture);
      break;
    case "reset":
      session.editor.resetCamera();
      break;
    case "side":
      session.guide.viewFrom(command.letter);
      break;
    case "tour":
      void session.guide.tour.toggle();
      break;
    case "pause":
      session.guide.tour.pauseOrContinue();
      break;
    case "play":
      session.phases.toggle();
      break;
    case "phase":
      session.phases.step(command.by);
      break;
    case "preset": {
      const preset = session.editor.presets.value[command.index];
      if (preset) session.editor.applyPreset(preset);
      break;
    }
    case "fullscreen":
      if (page) void toggleFullscreen(page);
      break;
    case "screenshot":
      open("export");
      break;
    case "help":
      open("help");
      break;
    case "slices":
      if (slices) toggleSlices(session.slices);
      break;
    case "alone":
      maximiseFocused(session.slices);
      break;
  }
}

async function toggleFullscreen(element: HTMLElement): Promise<void> {
  try {
    if (document.fullscreenElement) await document.exitFullscreen();
    else await element.requestFullscreen();
  } catch {
    // Phones and frames may forbid full screen. The page then stays as it is.
  }
}
