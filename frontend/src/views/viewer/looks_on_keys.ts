import { mostLookKeys } from "../../input/keys";
import type { Role } from "../../live/role";
import type { ViewerSession } from "../../video/viewer_session";

/** Returns how many looks the number keys choose from. A viewer who only follows has none. */
export const looksOnKeys = (session: ViewerSession | null, role: Role): number =>
  session !== null && role.presents ? Math.min(session.editor.presets.value.length, mostLookKeys) : 0;
