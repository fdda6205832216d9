import { marksOfNames } from "./series_names";
import type { Series } from "./types";

/** Maximum number of characters that the server keeps. */
const longest = 80;
/** Minimum length of a part of a name. Shorter ones, such as "de", occur in any text. */
const shortestNamePart = 3;

const wordsOf = (text: string): string[] => text.toLowerCase().match(/[\p{L}\p{N}]+/gu) ?? [];

/** Whether a text of the scan contains part of the patient's name or ID number. */
function namesPatient(text: string, { name, id }: Series["patient"]): boolean {
  const found = new Set(wordsOf(text));
  return wordsOf(`${name} ${id}`).some((part) => part.length >= shortestNamePart && found.has(part));
}

type Titled = Pick<Series, "description" | "bodyPart" | "modality" | "patient">;

/**
 * Proposes a title, which the user can change: the description of the series, followed by `mark` and `date`. The
 * modality and the body part replace a description that is missing or names the patient. If they name the patient
 * too, only `date` and `mark` remain.
 * @param date The date of the series in the user's format, or an empty string.
 * @param mark A suffix that distinguishes the series from others with the same title, or an empty string.
 */
export function proposedTitle({ description, bodyPart, modality, patient }: Titled, date: string, mark = ""): string {
  const shown = [description, [modality, bodyPart].filter(Boolean).join(" ")]
    .map((text) => text.replace(/[\s_]+/g, " ").trim())
    .find((text) => text !== "" && !namesPatient(text, patient));
  const end = date === "" ? mark : `${shown ? `${mark}, ` : ""}${date}${shown ? "" : mark}`;
  return ((shown ?? "").slice(0, longest - end.length) + end).slice(0, longest);
}

/**
 * Returns the proposed titles of series by their keys. No two are the same unless they are empty,
 * so that their cards can be told apart.
 */
export function proposedTitles(
  series: readonly (Titled & Pick<Series, "key" | "seriesNumber" | "date">)[],
  dateText: (date: string) => string,
): ReadonlyMap<string, string> {
  const titleOf = (one: Titled & Pick<Series, "date">, mark = "") => proposedTitle(one, dateText(one.date), mark);
  const marks = marksOfNames(series, (one) => titleOf(one));
  return new Map(series.map((one) => [one.key, titleOf(one) && titleOf(one, marks.get(one.key))]));
}
