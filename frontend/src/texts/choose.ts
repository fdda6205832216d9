/** The languages of the page, each by its own name. */
export const languages = { en: "English", de: "Deutsch" } as const;
export type Language = keyof typeof languages;

const is_language = (text: string | null): text is Language => text !== null && Object.hasOwn(languages, text);

const language_of = (tag: string): string => tag.split("-", 1)[0]?.toLowerCase() ?? "";

/** `kept`: what a person chose before. `wanted`: BCP 47 tags of the browser, the best liked first. */
export function choose_language(kept: string | null, wanted: readonly string[]): Language {
  if (is_language(kept)) return kept;
  return wanted.map(language_of).find(is_language) ?? "en";
}

/** By whose habits numbers and dates are written: en-GB and en-US differ. */
export const place_of = (language: Language, wanted: readonly string[]): string =>
  wanted.find((tag) => language_of(tag) === language) ?? language;
