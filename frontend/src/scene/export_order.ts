import type { ScanExportOrder, ScanFormat } from "../api/scan_exports";

/** What the form for a file of the scan says. */
export interface ExportEntries {
  readonly format: ScanFormat;
  /** The number of a label, or "" for everything from a value upwards. */
  readonly part: string;
  readonly above: string;
}

/** The values of the scan. */
export interface ValueRange {
  readonly minimum: number;
  readonly maximum: number;
}

/**
 * Returns the order, or null if the value is not a whole number within the scan. A surface is that of the phase that is
 * shown.
 */
export function exportOrderOf(entries: ExportEntries, range: ValueRange, phase = 0): ScanExportOrder | null {
  const { format, part } = entries;
  if (format === "nifti") return { format };
  if (part !== "") return { format, label: Number(part) };
  const text = entries.above.trim().replace("−", "-");
  if (!/^-?\d{1,6}$/.test(text)) return null;
  const above = Number(text);
  if (above < range.minimum || above > range.maximum) return null;
  return phase > 0 ? { format, above, phase } : { format, above };
}

/** The lowest value of compact bone in a CT, in Hounsfield units. */
const bone = 300;

/** Returns a value that encloses something: bone in a CT, and else the brightest quarter of the scan. */
export function usualThreshold(range: ValueRange, isCt: boolean, percentiles: readonly number[]): number {
  if (isCt && range.minimum <= bone && range.maximum >= bone) return bone;
  const upperQuartile = percentiles[4] ?? (range.minimum + range.maximum) / 2;
  return Math.round(Math.min(Math.max(upperQuartile, range.minimum), range.maximum));
}
