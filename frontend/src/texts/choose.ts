/** The languages of the page, each by its own name. */
export const languages = { en: "English", de: "Deutsch" } as const;
export type Language = keyof typeof languages;

const isLanguage = (text: string | null): text is Language => text !== null && Object.hasOwn(languages, text);

const languageOf = (tag: string): string => tag.split("-", 1)[0]?.toLowerCase() ?? "";

/** `kept`: what a person chose before. `wanted`: BCP 47 tags of the browser, the best liked first. */
export function chooseLanguage(kept: string | null, wanted: readonly string[]): Language {
  if (isLanguage(kept)) return kept;
  return wanted.map(languageOf).find(isLanguage) ?? "en";
}

/** By whose habits numbers and dates are written: en-GB and en-US differ. */
export const placeOf = (language: Language, wanted: readonly string[]): string =>
  wanted.find((tag) => languageOf(tag) === language) ?? language;
