import { add, length, subtract, vec3, type Vec3 } from "../input/vec3";

export const markKinds = ["arrow", "circle", "text"] as const;
export type MarkKind = (typeof markKinds)[number];

/** Limits of the protocol. */
export const mostMarks = 50;
export const longestText = 80;
/** The colours are those of pointers (style/picture.css). */
export const markColours = 8;

/** An arrow, a circle or a text at a point of the scan. Lengths and points are in mm in world space. */
export interface Mark {
  /** Unique among the marks of one person. */
  readonly id: number;
  readonly kind: MarkKind;
  readonly colour: number;
  readonly text: string;
  /** The tip of an arrow, the middle of a circle, or the point that a text is about. */
  readonly place: Vec3;
  /** The place where an arrow begins. */
  readonly tail: Vec3;
  /** The radius of a circle, which is the outline of a sphere. */
  readonly radius: number;
  /** The saved set that the mark belongs to. Absent if it is not saved. */
  readonly set?: string;
}

const noPlace = vec3(0, 0, 0);

export const newMark = (kind: MarkKind, place: Vec3, colour: number): Omit<Mark, "id"> => ({
  kind,
  colour,
  place,
  text: "",
  tail: noPlace,
  radius: 0,
});

/** Moves a mark as a whole. */
export const movedTo = (mark: Mark, place: Vec3): Mark => ({
  ...mark,
  place,
  tail: mark.kind === "arrow" ? add(mark.tail, subtract(place, mark.place)) : mark.tail,
});

/** Moves the second handle: where an arrow begins, or the edge of a circle. */
export function withEnd(mark: Mark, end: Vec3): Mark {
  if (mark.kind === "arrow") return { ...mark, tail: end };
  if (mark.kind === "circle") return { ...mark, radius: Math.max(0.5, length(subtract(end, mark.place))) };
  return mark;
}

/** Shortens a text to what the server accepts. An emoji is one character. */
export const shortText = (text: string): string => Array.from(text).slice(0, longestText).join("");

/** Moves a mark or a measurement to a saved set, or out of its set if `set` is undefined. */
export function withSet<Item extends { readonly set?: string }>(item: Item, set?: string): Item {
  const rest = Object.fromEntries(Object.entries(item).filter(([name]) => name !== "set")) as Item;
  return set === undefined ? rest : { ...rest, set };
}

export const nextId = (marks: readonly Mark[]): number => marks.reduce((most, { id }) => Math.max(most, id), 0) + 1;
