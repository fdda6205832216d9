import type { Keeping } from "../../storage";

const key = "diaphane.hints";
type Store = Pick<Keeping, "getItem" | "keep">;

/** Whether the hints are shown: once a browser. Where nothing can be kept they would come again each time, so they never do. */
export const hintsDue = (store: Store): boolean => store.getItem(key) === null && store.keep(`${key}.can`, "yes");

export const hintsSeen = (store: Store): boolean => store.keep(key, "seen");
