/** Decimal, as discs and quotas are counted. */
export function bytes_text(bytes: number): string {
  const units = ["bytes", "KB", "MB", "GB", "TB"];
  let value = bytes;
  let unit = 0;
  while (value >= 1000 && unit < units.length - 1) {
    value /= 1000;
    unit += 1;
  }
  return `${unit === 0 || value >= 100 ? value.toFixed(0) : value.toFixed(1)} ${units[unit] ?? ""}`;
}

/** A DICOM date (yyyymmdd) as this person writes dates; empty when it is none. */
export function dicom_date_text(date: string): string {
  const match = /^(\d{4})(\d{2})(\d{2})$/.exec(date.replaceAll(".", "").trim());
  if (!match) return "";
  const [, year, month, day] = match;
  return new Intl.DateTimeFormat(undefined, { dateStyle: "medium", timeZone: "UTC" }).format(
    new Date(Date.UTC(Number(year), Number(month) - 1, Number(day))),
  );
}

/** The day and the time of an RFC 3339 instant, as this person writes them. */
export const date_text = (instant: string): string =>
  new Intl.DateTimeFormat(undefined, { dateStyle: "medium", timeStyle: "short" }).format(new Date(instant));

/** The time of the day, of milliseconds since 1970. */
export const time_text = (at_ms: number): string => new Intl.DateTimeFormat(undefined, { timeStyle: "short" }).format(at_ms);

/** A time of the server as this person writes days. */
export const day_text = (time: string): string => new Intl.DateTimeFormat(undefined, { dateStyle: "long" }).format(new Date(time));
