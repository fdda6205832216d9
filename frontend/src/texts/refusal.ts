import { language, t } from ".";
import type { DataSet } from "../api/types";

/** Why the server could not show a scan. Its own sentence has the figures but is English; other languages have the reason's text. */
export function refusalText({ code, text }: NonNullable<DataSet["refusal"]>): string {
  if (language.value === "en") return text;
  const reasons: Readonly<Record<string, (n: number) => string>> = t.add.reasons;
  const reason = Object.hasOwn(reasons, code) ? reasons[code] : undefined;
  return reason?.length === 0 ? reason(0) : text; // how many, only the sentence says
}
