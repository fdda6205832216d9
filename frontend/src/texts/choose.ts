/** The languages of the page, each under its native name. */
export const languages = { en: "English", de: "Deutsch" } as const;
export type Language = keyof typeof languages;

const isLanguage = (text: string | null): text is Language => text !== null && Object.hasOwn(languages, text);

const languageOf = (tag: string): string => tag.split("-", 1)[0]?.toLowerCase() ?? "";

/**
 * Returns the language of the page. `kept` is the user's earlier choice. `preferred` lists the
 * browser's BCP 47 tags, most preferred first.
 */
export function chooseLanguage(kept: string | null, preferred: readonly string[]): Language {
  if (isLanguage(kept)) return kept;
  return preferred.map(languageOf).find(isLanguage) ?? "en";
}

/** Returns the locale for numbers and dates: en-GB and en-US differ. */
export const placeOf = (language: Language, preferred: readonly string[]): string =>
  preferred.find((tag) => languageOf(tag) === language) ?? language;
