import { t } from "../texts";
import { measuredBy, type Mark } from "./mark";

/** Returns what is written beside a mark: its text, and what it measures. */
export function saidOf(mark: Mark): string {
  const value = measuredBy(mark);
  if (value === null) return mark.text;
  const measured = mark.kind === "angle" ? t.slices.angle(value) : t.slices.ruler(value);
  return mark.text ? `${mark.text}: ${measured}` : measured;
}
