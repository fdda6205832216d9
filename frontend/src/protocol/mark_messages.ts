import { create, fromBinary, fromJson, toBinary, toJson, type JsonValue } from "@bufbuild/protobuf";
import { markColours, measuringPoints, shortText, type Mark, type MarkKind } from "../marks/mark";
import type { Measure } from "../slices/measure";
import { plain } from "./messages";
import { measurementsOf, measuresOf } from "./shared_messages";
import {
  AnnotationsSchema,
  ClientMessageSchema,
  Mark_Kind as Kind,
  MarkSchema,
  MarkSightQuerySchema,
  MarksSchema,
  RaiseHandSchema,
  type ClientMessage,
  type Mark as MarkMessage,
  type MarkSight,
  type Marks,
  type SharedState,
} from "./gen/api/proto/stream_pb";
import { Vec3Schema } from "./gen/api/proto/scene_pb";

export type { MarkSight };

type Bytes = Uint8Array<ArrayBuffer>;
const encoded = (body: ClientMessage["body"]): Bytes =>
  toBinary(ClientMessageSchema, create(ClientMessageSchema, { body }));

const kinds: Readonly<Record<MarkKind, Kind>> = {
  arrow: Kind.ARROW,
  circle: Kind.CIRCLE,
  text: Kind.TEXT,
  ruler: Kind.RULER,
  angle: Kind.ANGLE,
};

export const messageOf = ({ id, kind, colour, text, place, tail, end, radius }: Mark): MarkMessage =>
  create(MarkSchema, {
    id,
    kind: kinds[kind],
    colour,
    text,
    place: create(Vec3Schema, place),
    ...(kind === "arrow" || kind in measuringPoints ? { tail: create(Vec3Schema, tail) } : {}),
    ...(kind === "angle" ? { end: create(Vec3Schema, end) } : {}),
    radius: kind === "circle" ? radius : 0,
  });

const messagesOf = (marks: readonly Mark[]): Marks => create(MarksSchema, { items: marks.map(messageOf) });

/** Converts marks, except those of a kind that this page does not know. */
export function marksOf(marks: Marks | undefined): readonly Mark[] {
  return (marks?.items ?? []).flatMap((one) => {
    const kind = (Object.keys(kinds) as MarkKind[]).find((name) => kinds[name] === one.kind);
    if (!kind) return [];
    return [
      {
        id: one.id,
        kind,
        colour: one.colour % markColours,
        text: shortText(one.text),
        place: plain(one.place),
        tail: plain(one.tail),
        end: plain(one.end),
        radius: one.radius,
      },
    ];
  });
}

export const encodeMarks = (marks: readonly Mark[]): Bytes => encoded({ case: "marks", value: messagesOf(marks) });

export const encodeMarkSightQuery = (): Bytes => encoded({ case: "markSight", value: create(MarkSightQuerySchema) });

/** Raises or lowers this viewer's hand, or lowers the hand of the participant with the ID `of`. */
export const encodeHand = (on: boolean, of = ""): Bytes =>
  encoded({ case: "raiseHand", value: create(RaiseHandSchema, { on, of }) });

/** Returns the marks of the participants whose marks have changed, by their numbers. */
export const sharedMarksOf = ({ marks }: SharedState): readonly (readonly [number, readonly Mark[]])[] =>
  marks.map((one) => [one.number, marksOf(one.marks)] as const);

/** Marks and measurements as they are saved with scans and presets, and written into links. */
export interface Annotations {
  readonly marks: readonly Mark[];
  readonly measures: readonly Measure[];
}

const annotationsMessage = ({ marks, measures }: Annotations) =>
  create(AnnotationsSchema, {
    // Numbered from 1, so that the content does not depend on what else was shown.
    marks: messagesOf(marks.map((mark, i) => ({ ...mark, id: i + 1 }))),
    measurements: measurementsOf(measures),
  });

export const annotationsToJson = (annotations: Annotations): JsonValue =>
  toJson(AnnotationsSchema, annotationsMessage(annotations));

/** Parses saved annotations. Returns null if `json` does not contain any. */
export function annotationsFromJson(json: unknown): Annotations | null {
  try {
    const { marks, measurements } = fromJson(AnnotationsSchema, json as JsonValue, { ignoreUnknownFields: true });
    return { marks: marksOf(marks), measures: measurements ? measuresOf(measurements) : [] };
  } catch {
    return null;
  }
}

export const annotationsToBytes = (annotations: Annotations): Bytes =>
  toBinary(AnnotationsSchema, annotationsMessage(annotations));

export function annotationsFromBytes(bytes: Uint8Array): Annotations {
  const { marks, measurements } = fromBinary(AnnotationsSchema, bytes);
  return { marks: marksOf(marks), measures: measurements ? measuresOf(measurements) : [] };
}
