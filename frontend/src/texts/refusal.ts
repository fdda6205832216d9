import { language, t } from ".";
import type { DataSet } from "../api/types";

/**
 * Returns why the server can't show a scan. Its own text contains the figures but is English, so
 * other languages use the text of the reason.
 */
export function refusalText({ code, text }: NonNullable<DataSet["refusal"]>): string {
  if (language.value === "en") return text;
  const reasons: Readonly<Record<string, (n: number) => string>> = t.add.reasons;
  const reason = Object.hasOwn(reasons, code) ? reasons[code] : undefined;
  const count = /\d+/.exec(text)?.[0]; // Only the server's text contains the number.
  return reason && (reason.length === 0 || count !== undefined) ? reason(Number(count ?? 0)) : text;
}

/** Returns why the server refused a file of labels. */
export function labelRefusalText({ code, text }: NonNullable<DataSet["refusal"]>): string {
  if (language.value === "en") return text;
  const reasons: Readonly<Record<string, string>> = t.labels.refused;
  return (Object.hasOwn(reasons, code) ? reasons[code] : undefined) ?? t.labels.refused.other;
}
