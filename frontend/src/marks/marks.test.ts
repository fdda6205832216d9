import { describe, expect, it } from "vitest";
import { vec3 } from "../input/vec3";
import {
  longestText,
  measuredBy,
  mostMarks,
  movedTo,
  newMark,
  pointsOf,
  withEnd,
  withPointFrom,
  type Mark,
} from "./mark";
import { Marks } from "./marks";
import { saidOf } from "./said";

const at = (x: number) => newMark("text", vec3(x, 0, 0), 0);
const texts = ({ items }: Marks) => items.value.map(({ text }) => text);

describe("marks", () => {
  it("can be added, changed, deleted, and all of it undone and redone", () => {
    const marks = new Marks();
    const first = marks.add(at(1));
    expect(marks.selected.value).toBe(first?.id);
    for (const text of ["a", "ab", "abc"]) marks.setText(1, text);
    marks.rest();
    marks.add(at(2));
    marks.remove(1);
    expect(texts(marks)).toEqual([""]);
    marks.undo();
    marks.undo();
    expect(texts(marks)).toEqual(["abc"]);
    marks.undo();
    expect(texts(marks), "typing is one step").toEqual([""]);
    marks.redo();
    expect(texts(marks)).toEqual(["abc"]);
    marks.undo();
    marks.undo();
    expect(marks.items.value).toEqual([]);
    expect(marks.canUndo.value).toBe(false);
  });

  it("that were deleted meanwhile are not changed", () => {
    const marks = new Marks();
    marks.add(at(1));
    marks.remove(1);
    marks.change("move", 1, (mark) => movedTo(mark, vec3(9, 9, 9)));
    marks.undo();
    expect(marks.items.value[0]?.place).toEqual(vec3(1, 0, 0));
  });

  it("are at most as many and as long as the server accepts", () => {
    const marks = new Marks();
    for (let i = 0; i < mostMarks; i++) expect(marks.add(at(i))).not.toBeNull();
    expect(marks.add(at(0))).toBeNull();
    marks.setText(1, "🙂".repeat(longestText + 5));
    expect(Array.from(marks.find(1)?.text ?? "")).toHaveLength(longestText);
  });

  it("of a saved set are shown and hidden without touching the others", () => {
    const marks = new Marks();
    marks.add(at(1));
    marks.show("set", [
      { ...at(2), id: 1 },
      { ...at(3), id: 2 },
    ]);
    expect(marks.items.value.map(({ id, set }) => [id, set])).toEqual([
      [1, undefined],
      [2, "set"],
      [3, "set"],
    ]);
    marks.hide("set");
    expect(marks.items.value).toHaveLength(1);
    marks.undo();
    expect(marks.items.value, "hiding cannot be undone").toHaveLength(1);
  });

  it("of someone else's set stay when one's own are deleted", () => {
    const marks = new Marks();
    marks.add(at(1));
    marks.show("theirs", [{ ...at(2), id: 1 }]);
    marks.locked.value = new Set(["theirs"]);
    marks.clear();
    expect(marks.items.value.map(({ set }) => set)).toEqual(["theirs"]);
  });
});

describe("a mark", () => {
  const arrow: Mark = { ...newMark("arrow", vec3(1, 0, 0), 0), id: 1, tail: vec3(5, 5, 0) };

  it("moves as a whole", () => {
    expect(movedTo(arrow, vec3(2, 0, 3))).toMatchObject({ place: vec3(2, 0, 3), tail: vec3(6, 5, 3) });
  });

  it("gets the end to which it is dragged", () => {
    expect(withEnd(arrow, vec3(9, 9, 9)).tail).toEqual(vec3(9, 9, 9));
    const circle: Mark = { ...arrow, kind: "circle" };
    expect(withEnd(circle, vec3(1, 3, 4)).radius).toBe(5);
    expect(withEnd(circle, circle.place).radius, "it can still be seen").toBeGreaterThan(0);
  });
});

describe("a measurement in space", () => {
  const ruler: Mark = { ...newMark("ruler", vec3(1, 2, 3), 0), id: 1 };
  const angle: Mark = { ...newMark("angle", vec3(5, 0, 0), 0), id: 2 };

  it("gets its points one after the other, and the second one of an angle is its vertex", () => {
    expect(measuredBy(ruler), "both ends are at the first point").toBe(0);
    const long = withPointFrom(ruler, 1, vec3(4, 6, 15));
    expect(pointsOf(long)).toEqual([vec3(1, 2, 3), vec3(4, 6, 15)]);
    expect(measuredBy(long)).toBe(13);
    const bent = withPointFrom(withPointFrom(angle, 1, vec3(0, 0, 0)), 2, vec3(0, 0, 9));
    expect(bent).toMatchObject({ place: vec3(0, 0, 0), tail: vec3(5, 0, 0), end: vec3(0, 0, 9) });
    expect(measuredBy(bent)).toBeCloseTo(90);
  });

  it("says its value after its text, and an angle without sides says none", () => {
    const long = withPointFrom(ruler, 1, vec3(4, 6, 15));
    expect(saidOf(long)).toBe("13.0 mm");
    expect(saidOf({ ...long, text: "Cyst" })).toBe("Cyst: 13.0 mm");
    expect(saidOf(angle)).toBe("");
    expect(saidOf({ ...newMark("text", vec3(0, 0, 0), 0), id: 3, text: "Here" })).toBe("Here");
  });

  it("moves by its points alone", () => {
    const long = withPointFrom(ruler, 1, vec3(4, 6, 15));
    expect(movedTo(long, vec3(0, 0, 0))).toMatchObject({ place: vec3(0, 0, 0), tail: vec3(4, 6, 15) });
    expect(withEnd(long, vec3(1, 2, 4))).toMatchObject({ place: vec3(1, 2, 3), tail: vec3(1, 2, 4) });
  });
});
