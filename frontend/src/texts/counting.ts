/** Numbers as they stand in sentences of a language. */
export function counting(language: string) {
  const number = new Intl.NumberFormat(language);
  const plural = new Intl.PluralRules(language);
  return {
    number,
    /** So many digits behind the point, or the comma. */
    fixed: (n: number, digits = 0): string =>
      new Intl.NumberFormat(language, {
        minimumFractionDigits: digits,
        maximumFractionDigits: digits,
        useGrouping: false,
      }).format(n),
    /** For languages in which one thing has one form and any other number of them another. */
    count: (n: number, one: string, many: string): string =>
      `${number.format(n)} ${plural.select(n) === "one" ? one : many}`,
  };
}
