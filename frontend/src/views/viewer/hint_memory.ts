import { keep, kept } from "../kept";

const key = "diaphane.hints";
type Store = Parameters<typeof kept>[1];

/** Whether the hints are shown: once a browser. Where nothing can be kept they would come again each time, so they never do. */
export function hints_due(store?: Store): boolean {
  return kept(key, store) === null && keep(`${key}.can`, "yes", store);
}

export const hints_seen = (store?: Store): boolean => keep(key, "seen", store);
