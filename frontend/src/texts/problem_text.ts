import { language, t } from ".";
import type { ApiProblem } from "../api/client";

/** The server writes its sentences in English. In other languages, and without a sentence, returns `otherwise`. */
export const serverSentence = (sentence: string, otherwise: string): string =>
  language.value === "en" && sentence !== "" ? sentence : otherwise;

type Kinds = Readonly<Record<string, string>>;

/** What is wrong with a field, where the server's sentence is in another language. */
export function invalidText(field: string): string {
  const fields: Kinds = t.problems.fields;
  return (Object.hasOwn(fields, field) ? fields[field] : undefined) ?? t.problems.kinds.invalid;
}

/** The message for a problem that the server reports, by its kind. */
export function problemText({ kind, detail, errors }: Pick<ApiProblem, "kind" | "detail" | "errors">): string {
  const always: Kinds = t.problems.always;
  if (Object.hasOwn(always, kind)) return always[kind] ?? t.problems.internal;
  const kinds: Kinds = t.problems.kinds;
  const known = Object.hasOwn(kinds, kind) ? kinds[kind] : undefined;
  const [first] = errors;
  if (kind === "invalid" && first) return serverSentence(first.message, invalidText(first.field));
  return serverSentence(first?.message ?? detail, known ?? t.problems.internal);
}
