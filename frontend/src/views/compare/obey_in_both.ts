import type { KeyCommand } from "../../input/keys";
import type { ViewerSession } from "../../video/viewer_session";
import { obeyCommand } from "../viewer/obey_command";

export interface BothTargets {
  readonly sessions: readonly [ViewerSession | null, ViewerSession | null];
  /** The side on which the keys act. */
  readonly active: 0 | 1;
  /** Whether the other side follows by itself. */
  readonly linked: boolean;
  readonly page: HTMLElement | null;
  readonly help: () => void;
}

/** What makes sense for two pictures at once. */
const known: readonly KeyCommand["kind"][] = [
  ...(["gesture", "reset", "side", "preset", "fullscreen", "help", "play", "phase"] as const),
];

/** Executes a command in the active picture. Two pictures that are not linked are both reset. */
export function obeyInBoth(command: KeyCommand, { sessions, active, linked, page, help }: BothTargets): void {
  if (!known.includes(command.kind)) return;
  const all = command.kind === "reset" && !linked ? sessions : [sessions[active]];
  for (const session of all) if (session) obeyCommand(command, { session, page, slices: false, open: help });
}
