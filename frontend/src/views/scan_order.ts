import type { DataSet } from "../api/types";
import { dateInTitle } from "../scan/title_date";

/** The orders of the list of scans. The server sends the newest first. */
export const scanOrders = ["added", "date", "title", "size"] as const;
export type ScanOrder = (typeof scanOrders)[number];

/** The key under which this browser remembers the order. */
export const orderKey = "diaphane.scan_order";

export const scanOrderOf = (text: string | null): ScanOrder => scanOrders.find((one) => one === text) ?? "added";

type Ordered = Pick<DataSet, "title" | "created_at" | "volume">;

/**
 * Sorts scans by title alphabetically, by date with the newest first, or by size with the largest
 * first. Scans without that property come last. Ties, and "added", keep the order of the server.
 */
export function inOrder<Set extends Ordered>(sets: readonly Set[], order: ScanOrder, locale: string): readonly Set[] {
  if (order === "added") return sets;
  if (order === "title") {
    const { compare } = new Intl.Collator(locale, { numeric: true });
    return [...sets].sort((a, b) => Number(a.title === "") - Number(b.title === "") || compare(a.title, b.title));
  }
  const keyOf = (set: Set): number =>
    (order === "date" ? dateInTitle(set.title, locale) : set.volume?.bytes) ?? -Infinity;
  const keys = new Map(sets.map((set) => [set, keyOf(set)]));
  return [...sets].sort((a, b) => {
    const [one, other] = [keys.get(a) ?? 0, keys.get(b) ?? 0];
    return one === other ? 0 : other - one;
  });
}
