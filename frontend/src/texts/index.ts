import { signal } from "@preact/signals";
import { local } from "../storage";
import { chooseLanguage, placeOf, type Language } from "./choose";
import type { Texts } from "./shape";

/** Loads only the selected language. */
const catalogues: Record<Language, () => Promise<Texts>> = {
  en: async () => (await import("./en/en")).en,
  de: async () => (await import("./de")).de,
};

const key = "diaphane.language";

/** All texts of the page in `language`. Read it when rendering, not when a module loads, because it can change. */
export let t: Texts;
export const language = signal<Language>("en");

/** Returns the user's locale, for dates and numbers in `Intl`. */
export const place = (): string => placeOf(language.value, navigator.languages);

export async function loadTexts(chosen: Language): Promise<void> {
  t = await catalogues[chosen]();
  language.value = chosen;
}

export const firstLanguage = (): Language => chooseLanguage(local.getItem(key), navigator.languages);

/** Changes the language now and for later visits. */
export async function changeLanguage(chosen: Language): Promise<void> {
  await loadTexts(chosen);
  local.setItem(key, chosen);
}
