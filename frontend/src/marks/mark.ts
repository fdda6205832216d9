import { add, length, subtract, vec3, type Vec3 } from "../input/vec3";
import { measured } from "../slices/measure";

export const markKinds = ["arrow", "circle", "text", "ruler", "angle"] as const;
export type MarkKind = (typeof markKinds)[number];

/** Limits of the protocol. */
export const mostMarks = 50;
export const longestText = 80;
/** The colours are those of pointers (style/picture.css). */
export const markColours = 8;

/** The kinds that measure between points of the scan, with the number of these points. */
export const measuringPoints: Readonly<Partial<Record<MarkKind, number>>> = { ruler: 2, angle: 3 };

/** An arrow, a circle, a text, a ruler or an angle at a point of the scan. Lengths and points are in mm in world space. */
export interface Mark {
  /** Unique among the marks of one person. */
  readonly id: number;
  readonly kind: MarkKind;
  readonly colour: number;
  readonly text: string;
  /** The tip of an arrow, the middle of a circle, the point that a text is about, one end of a ruler, or a vertex. */
  readonly place: Vec3;
  /** The place where an arrow begins, the other end of a ruler, or a point on the first side of an angle. */
  readonly tail: Vec3;
  /** A point on the second side of an angle. */
  readonly end: Vec3;
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
  tail: kind in measuringPoints ? place : noPlace,
  end: kind === "angle" ? place : noPlace,
  radius: 0,
});

/** Returns the points of a mark, in the order in which they are chosen. The second one of an angle is its vertex. */
export function pointsOf({ kind, place, tail, end }: Mark): readonly Vec3[] {
  if (kind === "ruler") return [place, tail];
  return kind === "angle" ? [tail, place, end] : [place];
}

/** Returns a ruler or an angle whose points from `index` on are the given one. */
export function withPointFrom(mark: Mark, index: number, point: Vec3): Mark {
  const [a = point, b = point, c = point] = pointsOf(mark).map((old, i) => (i < index ? old : point));
  return mark.kind === "ruler" ? { ...mark, place: a, tail: b } : { ...mark, tail: a, place: b, end: c };
}

/** Returns the length of a ruler in mm or the size of an angle in degrees, or null for another mark. */
export function measuredBy(mark: Mark): number | null {
  if (mark.kind !== "ruler" && mark.kind !== "angle") return null;
  return measured({ kind: mark.kind, plane: null, slice: 0, points: pointsOf(mark) });
}

/** Moves a mark as a whole. */
export const movedTo = (mark: Mark, place: Vec3): Mark => ({
  ...mark,
  place,
  tail: mark.kind === "arrow" ? add(mark.tail, subtract(place, mark.place)) : mark.tail,
});

/** Moves the second handle: where an arrow begins, or the edge of a circle. */
export function withEnd(mark: Mark, end: Vec3): Mark {
  if (mark.kind === "arrow" || mark.kind in measuringPoints) return { ...mark, tail: end };
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
