import type { OpenSocket } from "./stream_client";

/** Close codes of docs/contracts.md, "Stream". */
const sessionGone = 4404;
const linkEnded = 4410;

/**
 * Opens a visitor's stream. A visit is over when its session is. Otherwise, the page would begin
 * the next visit at once, and nobody's time would ever end.
 */
export const forVisit =
  (open: OpenSocket): OpenSocket =>
  (url, events) =>
    open(url, { ...events, closed: (code) => events.closed(code === sessionGone ? linkEnded : code) });
