import type { OpenSocket } from "./stream_client";

/** Close codes of docs/contracts.md, "Stream". */
const sessionGone = 4404;
const linkEnded = 4410;

/**
 * Opens a visitor's stream and treats the end of its session as the end of the visit. If it were
 * treated as a lost connection, the page would begin the next visit at once, and visits would never
 * end.
 */
export const forVisit =
  (open: OpenSocket): OpenSocket =>
  (url, events) =>
    open(url, { ...events, closed: (code) => events.closed(code === sessionGone ? linkEnded : code) });
