import { language, t } from ".";
import type { ApiProblem } from "../api/client";

/**
 * Returns the server's sentence, which is English, or `otherwise` in other languages and without a
 * sentence.
 */
export const serverSentence = (sentence: string, otherwise: string): string =>
  language.value === "en" && sentence !== "" ? sentence : otherwise;

type Kinds = Readonly<Record<string, string>>;

/** Returns the message for an invalid field, for languages in which the server has no sentence. */
export function invalidText(field: string): string {
  const fields: Kinds = t.problems.fields;
  return (Object.hasOwn(fields, field) ? fields[field] : undefined) ?? t.problems.kinds.invalid;
}

/** Returns the message for a problem that the server reports, by its kind. */
export function problemText({ kind, detail, errors }: Pick<ApiProblem, "kind" | "detail" | "errors">): string {
  const always: Kinds = t.problems.always;
  if (Object.hasOwn(always, kind)) return always[kind] ?? t.problems.internal;
  const kinds: Kinds = t.problems.kinds;
  const known = Object.hasOwn(kinds, kind) ? kinds[kind] : undefined;
  const [first] = errors;
  if (kind === "invalid" && first) return serverSentence(first.message, invalidText(first.field));
  return serverSentence(first?.message ?? detail, known ?? t.problems.internal);
}
