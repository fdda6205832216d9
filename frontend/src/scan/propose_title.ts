import type { Series } from "./types";

/** As many characters as the server keeps. */
const longest = 80;
/** Shorter parts of a name, such as "de", occur in any text. */
const shortestNamePart = 3;

const wordsOf = (text: string): string[] => text.toLowerCase().match(/[\p{L}\p{N}]+/gu) ?? [];

/** Whether a text of the scan contains part of the patient's name or their number. */
function namesPatient(text: string, { name, id }: Series["patient"]): boolean {
  const found = new Set(wordsOf(text));
  return wordsOf(`${name} ${id}`).some((part) => part.length >= shortestNamePart && found.has(part));
}

/**
 * A title for the person to change or keep: what the series shows and its date, in the words of the scan.
 * Empty where the scan says neither. A description that names the patient is left out.
 * @param date as this person writes dates, or empty.
 */
export function proposedTitle(
  { description, bodyPart, modality, patient }: Pick<Series, "description" | "bodyPart" | "modality" | "patient">,
  date: string,
): string {
  const shown = [description, [modality, bodyPart].filter(Boolean).join(" ")]
    .map((text) => text.replace(/[\s_]+/g, " ").trim())
    .find((text) => text !== "" && !namesPatient(text, patient));
  const end = date === "" ? "" : `${shown ? ", " : ""}${date}`;
  return ((shown ?? "").slice(0, longest - end.length) + end).slice(0, longest);
}
