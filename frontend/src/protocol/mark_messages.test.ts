import { create, fromBinary } from "@bufbuild/protobuf";
import { expect, it } from "vitest";
import { vec3 } from "../input/vec3";
import { newMark, type Mark } from "../marks/mark";
import { ClientMessageSchema, Mark_Kind as Kind, MarkSchema, MarksSchema } from "./gen/api/proto/stream_pb";
import {
  annotationsFromBytes,
  annotationsFromJson,
  annotationsToBytes,
  annotationsToJson,
  encodeMarks,
  marksOf,
} from "./mark_messages";

const arrow: Mark = { ...newMark("arrow", vec3(1, 2, 3), 5), id: 7, text: "Hier", tail: vec3(4, 5, 6) };
const circle: Mark = { ...newMark("circle", vec3(0, 0, 1), 0), id: 9, radius: 4.5 };

const ruler: Mark = { ...newMark("ruler", vec3(1, 2, 3), 1), id: 10, tail: vec3(9, 8, 7) };
const angle: Mark = { ...newMark("angle", vec3(1, 2, 3), 2), id: 11, tail: vec3(9, 8, 7), end: vec3(6, 5, 4) };

it("marks reach the others as they are", () => {
  const { body } = fromBinary(ClientMessageSchema, encodeMarks([arrow, circle, ruler, angle]));
  expect(body.case === "marks" && marksOf(body.value)).toEqual([arrow, circle, ruler, angle]);
});

it("a mark of an unknown kind is left out", () => {
  const items = [create(MarkSchema, { id: 1 }), create(MarkSchema, { id: 2, kind: Kind.TEXT })];
  expect(marksOf(create(MarksSchema, { items })).map(({ id }) => id)).toEqual([2]);
});

it("annotations keep everything but the numbers and the set", () => {
  const measures = [
    { kind: "ruler" as const, plane: "axial" as const, slice: 3, points: [vec3(1, 0, 0), vec3(2, 0, 0)] },
    { kind: "angle" as const, plane: null, slice: 0, points: [vec3(1, 0, 0), vec3(2, 0, 0), vec3(2, 1, 1)] },
    { kind: "ellipse" as const, plane: null, slice: 0, points: [vec3(1, 0, 0), vec3(2, 3, 0)], corner: vec3(1, 3, 0) },
  ];
  const [first, ...rest] = measures;
  const annotations = { marks: [{ ...arrow, set: "a" }, circle], measures: [{ ...first, set: "a" } as never, ...rest] };
  const expected = {
    marks: [
      { ...arrow, id: 1 },
      { ...circle, id: 2 },
    ],
    measures,
  };
  expect(annotationsFromJson(JSON.parse(JSON.stringify(annotationsToJson(annotations))))).toEqual(expected);
  expect(annotationsFromBytes(annotationsToBytes(annotations))).toEqual(expected);
  expect(annotationsFromJson("no object")).toBeNull();
});
