import { signal } from "@preact/signals";
import { local } from "../storage";
import { choose_language, place_of, type Language } from "./choose";
import type { en } from "./en/en";
import type { Translation } from "./shape";

export type Texts = Translation<typeof en>;

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
export const place = (): string => place_of(language.value, navigator.languages);

export async function load_texts(wanted: Language): Promise<void> {
  t = await catalogues[wanted]();
  language.value = wanted;
}

export const first_language = (): Language => choose_language(local.getItem(key), navigator.languages);

/** As a person chose it, here and at the next visit. */
export async function change_language(wanted: Language): Promise<void> {
  await load_texts(wanted);
  local.setItem(key, wanted);
}
