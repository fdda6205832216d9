import type { Keeping } from "../../storage";

const key = "diaphane.hints";
type Store = Pick<Keeping, "getItem" | "keep">;

/**
 * Whether to show the tips, once per browser. If the browser stores nothing, they are never shown, because they would
 * appear every time.
 */
export const hintsDue = (store: Store): boolean => store.getItem(key) === null && store.keep(`${key}.can`, "yes");

export const hintsSeen = (store: Store): boolean => store.keep(key, "seen");
