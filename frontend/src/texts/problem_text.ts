import { language, t } from ".";
import type { ApiProblem } from "../api/client";

/** The server writes its sentences in English. In other languages, and without a sentence, returns `otherwise`. */
export const serverSentence = (sentence: string, otherwise: string): string =>
  language.value === "en" && sentence !== "" ? sentence : otherwise;

type Kinds = Readonly<Record<string, string>>;

/** The message for a problem that the server reports, by its kind. */
export function problemText({ kind, detail, errors }: Pick<ApiProblem, "kind" | "detail" | "errors">): string {
  const always: Kinds = t.problems.always;
  if (Object.hasOwn(always, kind)) return always[kind] ?? t.problems.internal;
  const kinds: Kinds = t.problems.kinds;
  const known = Object.hasOwn(kinds, kind) ? kinds[kind] : undefined;
  return serverSentence(errors[0]?.message ?? detail, known ?? t.problems.internal);
}
