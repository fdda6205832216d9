import { isNumber, isPoint } from "../input/vec3";
import { markColours, markKinds, mostMarks, nextId, shortText, type Mark, type MarkKind } from "./mark";

/** What this tab remembers of the marks across a reload. */
export interface RememberedMarks {
  readonly items: readonly Mark[];
  readonly shown: boolean;
  /** Sets with changes that the server may not have yet. */
  readonly unsaved: readonly string[];
  /** Hidden sets of the scan's owner. */
  readonly hidden: readonly string[];
}

export const marksToText = (marks: RememberedMarks): string => JSON.stringify(marks);

function isMark(value: unknown): value is Mark {
  const one = value as Partial<Record<keyof Mark, unknown>> | null;
  return (
    typeof one === "object" &&
    one !== null &&
    markKinds.includes(one.kind as MarkKind) &&
    isNumber(one.colour) &&
    typeof one.text === "string" &&
    isPoint(one.place) &&
    isPoint(one.tail) &&
    (one.end === undefined || isPoint(one.end)) &&
    isNumber(one.radius) &&
    (one.set === undefined || typeof one.set === "string")
  );
}

const textsOf = (value: unknown): readonly string[] =>
  Array.isArray(value) ? value.filter((one) => typeof one === "string") : [];

/** Parses what marksToText() returned. Returns null if the text is null, damaged or of another structure. */
export function marksFromText(text: string | null): RememberedMarks | null {
  try {
    const value = JSON.parse(text ?? "null") as Partial<Record<keyof RememberedMarks, unknown>> | null;
    if (value === null || !Array.isArray(value.items) || !value.items.every(isMark)) return null;
    let items: readonly Mark[] = [];
    for (const stored of value.items.slice(0, mostMarks)) {
      const { kind, colour, text: said, place, tail, radius, set } = stored;
      const end = (stored as Partial<Mark>).end ?? place; // absent in what an earlier page stored
      const shape = { kind, place, tail, end, radius };
      const mark = { id: nextId(items), ...shape, colour: Math.abs(Math.round(colour)) % markColours };
      items = [...items, { ...mark, text: shortText(said), ...(set === undefined ? {} : { set }) }];
    }
    return { items, shown: value.shown !== false, unsaved: textsOf(value.unsaved), hidden: textsOf(value.hidden) };
  } catch {
    return null;
  }
}
