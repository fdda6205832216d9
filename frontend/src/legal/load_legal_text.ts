import type { LegalPage } from "../views/routes";
import { languages, type Language } from "../texts/choose";
import { readLegalText, type LegalText } from "./legal_text";

export interface LoadedText extends LegalText {
  readonly language: Language;
}

type Get = (url: string) => Promise<Response>;

/**
 * Loads a text of the installation in `requested`. If that one is still the template, but the operator has filled in
 * another language, returns that one.
 */
export async function loadLegalText(page: LegalPage, requested: Language, get: Get = fetch): Promise<LoadedText> {
  const load = async (language: Language): Promise<LoadedText> => {
    const response = await get(`/legal/${page}.${language}.txt`);
    if (!response.ok) throw new Error(`${page}.${language}: ${response.status.toFixed(0)}`);
    return { ...readLegalText(await response.text()), language };
  };
  const first = await load(requested);
  if (!first.isTemplate) return first;
  const others = (Object.keys(languages) as Language[]).filter((one) => one !== requested);
  for (const other of others) {
    const text = await load(other).catch(() => first);
    if (!text.isTemplate) return text;
  }
  return first;
}
