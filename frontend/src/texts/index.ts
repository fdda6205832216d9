import { signal } from "@preact/signals";
import { local } from "../storage";
import { chooseLanguage, placeOf, type Language } from "./choose";
import type { Texts } from "./shape";

/** Only the language that is shown is loaded. */
const catalogues: Record<Language, () => Promise<Texts>> = {
  en: async () => (await import("./en/en")).en,
  de: async () => (await import("./de")).de,
};

const key = "diaphane.language";

/** Every text of the page, in `language`. Read it where it is shown, not when a module is loaded: it may change. */
export let t: Texts;
export const language = signal<Language>("en");

/** For `Intl`: dates and numbers as at the person's place. */
export const place = (): string => placeOf(language.value, navigator.languages);

export async function loadTexts(wanted: Language): Promise<void> {
  t = await catalogues[wanted]();
  language.value = wanted;
}

export const firstLanguage = (): Language => chooseLanguage(local.getItem(key), navigator.languages);

/** As a person chose it, here and at the next visit. */
export async function changeLanguage(wanted: Language): Promise<void> {
  await loadTexts(wanted);
  local.setItem(key, wanted);
}
