const monthsOf = (locale: string): readonly string[] =>
  Array.from({ length: 12 }, (_, month) =>
    new Intl.DateTimeFormat(locale, { month: "short", day: "numeric", timeZone: "UTC" })
      .formatToParts(new Date(Date.UTC(2000, month, 1)))
      .map(({ type, value }) => (type === "month" ? value.toLowerCase().slice(0, 3) : ""))
      .join(""),
  );

/** Whether dates such as 3/4/2026 begin with the month. */
const monthFirst = (locale: string): boolean =>
  new Intl.DateTimeFormat(locale).formatToParts(new Date()).find(({ type }) => type !== "literal")?.type === "month";

const forms =
  /(\d{4})-(\d{1,2})-(\d{1,2})|(\d{1,2})([./])\s?(\d{1,2})\5\s?(\d{4})|(\d{1,2})\.? (\p{L}{3,})\.? (\d{4})|(\p{L}{3,})\.? (\d{1,2}),? (\d{4})/gu;

/**
 * Returns the last date in the title of a scan, as written in the user's language. The page
 * proposes titles, and users change them.
 * @returns milliseconds since 1970, or null.
 */
export function dateInTitle(title: string, locale: string): number | null {
  const months = monthsOf(locale);
  const monthOf = (name: string | undefined) => months.indexOf((name ?? "").toLowerCase().slice(0, 3)) + 1;
  const dates = [...title.matchAll(forms)].map((found) => {
    const [, isoYear, isoMonth, isoDay, one, mark, two, year, dayBefore, nameAfter, yearNamed, name, day, yearLast] =
      found;
    if (isoYear) return [Number(isoYear), Number(isoMonth), Number(isoDay)] as const;
    if (year && mark === "/" && monthFirst(locale)) return [Number(year), Number(one), Number(two)] as const;
    if (year) return [Number(year), Number(two), Number(one)] as const;
    if (yearNamed) return [Number(yearNamed), monthOf(nameAfter), Number(dayBefore)] as const;
    return [Number(yearLast), monthOf(name), Number(day)] as const;
  });
  const valid = dates.filter(([, month, day]) => month >= 1 && month <= 12 && day >= 1 && day <= 31).at(-1);
  return valid ? Date.UTC(valid[0], valid[1] - 1, valid[2]) : null;
}
