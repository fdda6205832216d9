/** Formatters for numbers within sentences of a language. */
export function counting(language: string) {
  const number = new Intl.NumberFormat(language);
  const plural = new Intl.PluralRules(language);
  return {
    number,
    /** Formats `n` with exactly `digits` decimal places. */
    fixed: (n: number, digits = 0): string =>
      new Intl.NumberFormat(language, {
        minimumFractionDigits: digits,
        maximumFractionDigits: digits,
        useGrouping: false,
      }).format(n),
    /**
     * Formats a count in languages with two forms: one for a single thing and one for every other
     * number.
     */
    count: (n: number, one: string, many: string): string =>
      `${number.format(n)} ${plural.select(n) === "one" ? one : many}`,
  };
}
