import { shortNumber } from "../scene/numbers";
import { place } from "../texts";

/** Decimal, as discs and quotas are counted. */
export function bytesText(bytes: number): string {
  const units = ["bytes", "KB", "MB", "GB", "TB"];
  let value = bytes;
  let unit = 0;
  while (value >= 1000 && unit < units.length - 1) {
    value /= 1000;
    unit += 1;
  }
  return `${fixedText(value, unit === 0 || value >= 100 ? 0 : 1)} ${units[unit] ?? ""}`;
}

/** Formats a number with a fixed number of decimal places. */
export const fixedText = (value: number, digits: number): string =>
  new Intl.NumberFormat(place(), {
    minimumFractionDigits: digits,
    maximumFractionDigits: digits,
    useGrouping: false,
  }).format(value);

/** As short as `shortNumber`, with the decimal sign of the person's language. */
export const numberText = (value: number, digits?: number): string =>
  new Intl.NumberFormat(place(), { maximumFractionDigits: 20, useGrouping: false }).format(
    Number(shortNumber(value, digits)),
  );

/** A share in whole percent as this person's language writes it: 80%, or with a space. */
export const percentText = (share: number): string =>
  new Intl.NumberFormat(place(), { style: "percent", maximumFractionDigits: 0 }).format(share);

/** The same with as many digits as it has. */
export const percentExactText = (share: number): string =>
  new Intl.NumberFormat(place(), { style: "percent", maximumFractionDigits: 6 }).format(share);

/** A DICOM date (yyyymmdd) as this person writes dates; empty when it is none. */
export function dicomDateText(date: string): string {
  const match = /^(\d{4})(\d{2})(\d{2})$/.exec(date.replaceAll(".", "").trim());
  if (!match) return "";
  const [, year, month, day] = match;
  return new Intl.DateTimeFormat(place(), { dateStyle: "medium", timeZone: "UTC" }).format(
    new Date(Date.UTC(Number(year), Number(month) - 1, Number(day))),
  );
}

/** The day and the time of an RFC 3339 instant, as this person writes them. */
export const dateText = (instant: string): string =>
  new Intl.DateTimeFormat(place(), { dateStyle: "medium", timeStyle: "short" }).format(new Date(instant));

/** The time of the day, of milliseconds since 1970. */
export const timeText = (atMs: number): string => new Intl.DateTimeFormat(place(), { timeStyle: "short" }).format(atMs);

/** A time of the server as this person writes days. */
export const dayText = (time: string): string =>
  new Intl.DateTimeFormat(place(), { dateStyle: "long" }).format(new Date(time));
