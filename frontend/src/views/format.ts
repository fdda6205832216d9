import { shortNumber } from "../scene/numbers";
import { place } from "../texts";

/** Formats a size in decimal units, as for disks and quotas. */
export function bytesText(bytes: number): string {
  const units = ["", "KB", "MB", "GB", "TB"];
  let value = bytes;
  let unit = 0;
  while (value >= 1000 && unit < units.length - 1) {
    value /= 1000;
    unit += 1;
  }
  if (unit === 0)
    return new Intl.NumberFormat(place(), { style: "unit", unit: "byte", unitDisplay: "long" }).format(value);
  return `${fixedText(value, value >= 100 ? 0 : 1)} ${units[unit] ?? ""}`;
}

/** Formats a number with a fixed number of decimal places. */
export const fixedText = (value: number, digits: number): string =>
  new Intl.NumberFormat(place(), {
    minimumFractionDigits: digits,
    maximumFractionDigits: digits,
    useGrouping: false,
  }).format(value);

/** Formats a number as briefly as `shortNumber`, with the user's decimal separator. */
export const numberText = (value: number, digits?: number): string =>
  new Intl.NumberFormat(place(), { maximumFractionDigits: 20, useGrouping: false }).format(
    Number(shortNumber(value, digits)),
  );

/** Formats a number with all of its digits, such as a power of ten at an axis. */
export const plainNumberText = (value: number): string =>
  new Intl.NumberFormat(place(), { maximumFractionDigits: 20 }).format(value);

/** Formats a fraction as a whole percentage in the user's language, such as "80%" or "80 %". */
export const percentText = (share: number): string =>
  new Intl.NumberFormat(place(), { style: "percent", maximumFractionDigits: 0 }).format(share);

/** Formats a fraction as a percentage with all of its digits. */
export const percentExactText = (share: number): string =>
  new Intl.NumberFormat(place(), { style: "percent", maximumFractionDigits: 6 }).format(share);

/** Formats a DICOM date (yyyymmdd) for the user. Empty if it is invalid. */
export function dicomDateText(date: string): string {
  const match = /^(\d{4})(\d{2})(\d{2})$/.exec(date.replaceAll(".", "").trim());
  if (!match) return "";
  const [, year, month, day] = match;
  return new Intl.DateTimeFormat(place(), { dateStyle: "medium", timeZone: "UTC" }).format(
    new Date(Date.UTC(Number(year), Number(month) - 1, Number(day))),
  );
}

/** Formats the date and time of an RFC 3339 timestamp for the user. */
export const dateText = (instant: string): string =>
  new Intl.DateTimeFormat(place(), { dateStyle: "medium", timeStyle: "short" }).format(new Date(instant));

/** Formats the time of day of a timestamp in milliseconds since 1970. */
export const timeText = (atMs: number): string => new Intl.DateTimeFormat(place(), { timeStyle: "short" }).format(atMs);

/** Formats the day of an RFC 3339 timestamp with a short month. */
export const dayShortText = (instant: string): string =>
  new Intl.DateTimeFormat(place(), { dateStyle: "medium" }).format(new Date(instant));

/** Formats the day of an RFC 3339 timestamp with the month in full. */
export const dayText = (time: string): string =>
  new Intl.DateTimeFormat(place(), { dateStyle: "long" }).format(new Date(time));
