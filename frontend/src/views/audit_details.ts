import type { AuditEntry } from "../api/types";
import { t } from "../texts";
import { bytesText } from "./format";

/**
 * Returns the details of an entry in words. Unknown names and words of the server stay as they are.
 */
export function detailsText({ action, details }: Pick<AuditEntry, "action" | "details">): string {
  const order = Object.keys(t.admin.details); // Postgres sorts names by their length: "to" before "from"
  return Object.entries(details)
    .sort(([a], [b]) => order.indexOf(a) - order.indexOf(b))
    .map(([name, value]) => `${t.admin.details[name] ?? name}: ${valueText(action, name, value)}`)
    .join(", ");
}

/**
 * Matches an ID, which is shortened like those in the column beside it, so that the table fits the
 * window.
 */
const isId = /^[0-9a-f]{8}-[0-9a-f-]{27}$/;

function valueText(action: string, name: string, value: number | string): string {
  if (name === "scopes" && typeof value === "string")
    return value
      .split(".") // as the server joins them, because a word of the log has no spaces
      .map((scope) => t.admin.scopes[scope] ?? scope)
      .join("; ");
  if (typeof value === "string") return t.admin.detailWords[value] ?? (isId.test(value) ? value.slice(0, 8) : value);
  if (action === "account.storage-quota-changed") return bytesText(value);
  if (action === "account.render-quota-changed") return t.myAccount.hours(value);
  if (name === "failed") return t.admin.yes;
  if (name === "slices" || name === "downloads") return value === 0 ? t.admin.no : t.admin.yes;
  return String(value);
}
