import type { Labels_Label as Label } from "../../protocol/gen/api/proto/stream_pb";
import { foundPart } from "../../scene/labels";
import { t } from "../../texts";

export function nameOf({ name, number }: Pick<Label, "name" | "number">): string {
  if (name) return name;
  const part = foundPart(number);
  return part ? t.labels.found[part] : t.labels.untitled(number);
}
