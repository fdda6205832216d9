import { short_number } from "../scene/numbers";
import { place } from "../texts";

/** Decimal, as discs and quotas are counted. */
export function bytes_text(bytes: number): string {
  const units = ["bytes", "KB", "MB", "GB", "TB"];
  let value = bytes;
  let unit = 0;
  while (value >= 1000 && unit < units.length - 1) {
    value /= 1000;
    unit += 1;
  }
  return `${fixed_text(value, unit === 0 || value >= 100 ? 0 : 1)} ${units[unit] ?? ""}`;
}

/** So many digits behind the point, or the comma. */
export const fixed_text = (value: number, digits: number): string =>
  new Intl.NumberFormat(place(), { minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: false }).format(value);

/** As short as `short_number`, with the decimal sign of the person's language. */
export const number_text = (value: number, digits?: number): string =>
  new Intl.NumberFormat(place(), { maximumFractionDigits: 20, useGrouping: false }).format(Number(short_number(value, digits)));

/** A DICOM date (yyyymmdd) as this person writes dates; empty when it is none. */
export function dicom_date_text(date: string): string {
  const match = /^(\d{4})(\d{2})(\d{2})$/.exec(date.replaceAll(".", "").trim());
  if (!match) return "";
  const [, year, month, day] = match;
  return new Intl.DateTimeFormat(place(), { dateStyle: "medium", timeZone: "UTC" }).format(
    new Date(Date.UTC(Number(year), Number(month) - 1, Number(day))),
  );
}

/** The day and the time of an RFC 3339 instant, as this person writes them. */
export const date_text = (instant: string): string =>
  new Intl.DateTimeFormat(place(), { dateStyle: "medium", timeStyle: "short" }).format(new Date(instant));

/** The time of the day, of milliseconds since 1970. */
export const time_text = (at_ms: number): string => new Intl.DateTimeFormat(place(), { timeStyle: "short" }).format(at_ms);

/** A time of the server as this person writes days. */
export const day_text = (time: string): string => new Intl.DateTimeFormat(place(), { dateStyle: "long" }).format(new Date(time));
