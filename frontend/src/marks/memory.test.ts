import { expect, it } from "vitest";
import { vec3 } from "../input/vec3";
import { newMark } from "./mark";
import { marksFromText, marksToText } from "./memory";

it("marks survive a reload", () => {
  const items = [
    { ...newMark("arrow", vec3(1, 2, 3), 2), id: 1, text: "Here", tail: vec3(4, 5, 6), set: "saved" },
    { ...newMark("circle", vec3(0, 0, 0), 7), id: 2, radius: 12 },
  ];
  const remembered = { items, shown: false, unsaved: ["saved"], hidden: ["theirs"] };
  expect(marksFromText(marksToText(remembered))).toEqual(remembered);
});

it("a damaged memory is ignored", () => {
  for (const text of [null, "", "{", "[]", `{"items":[{"kind":"arrow"}]}`, `{"items":[{"kind":"star","colour":0}]}`])
    expect(marksFromText(text)).toBeNull();
});
