import { create, toBinary } from "@bufbuild/protobuf";
import {
  ClientMessageSchema,
  ErrorCurveQuerySchema,
  GoodViewsQuerySchema,
  Video_Path as VideoPath,
  FileMark_LabelSchema,
  FileMarkSchema,
  FileRequestSchema,
  FileTakenSchema,
  VideoSchema,
  KernelQuerySchema,
  KeyViewSchema,
  LargePictureSchema,
  type ClientMessage,
} from "./gen/api/proto/stream_pb";
import type { Mark } from "../marks/mark";
import { messageOf } from "./mark_messages";
import type { Scene, Viewport } from "./messages";

export { KernelReport_Origin as KernelOrigin } from "./gen/api/proto/stream_pb";
export type { ErrorCurve, FilePart, KernelReport } from "./gen/api/proto/stream_pb";

type Bytes = Uint8Array<ArrayBuffer>;
const encoded = (body: ClientMessage["body"]): Bytes =>
  toBinary(ClientMessageSchema, create(ClientMessageSchema, { body }));

/** A text as this page draws it: the coverage of its outline and, below it, of its letters. */
export interface MarkLabel {
  readonly width: number;
  readonly height: number;
  /** Compressed (zlib). */
  readonly coverage: Bytes;
  readonly scale: number;
  readonly margin: number;
  readonly baseline: number;
}

/** Marks that a worker draws into a file. `unit` is the size of a pixel of the page in pixels of the file. */
export interface FileMarks {
  readonly unit: number;
  readonly items: readonly { readonly mark: Mark; readonly label: MarkLabel | null }[];
}

/**
 * The content of a file that a worker creates. `error` is the estimated error at which a frame or a band is finished.
 */
export type FileOrder = { readonly marks?: FileMarks } & (
  | {
      readonly kind: "turntable" | "tour" | "phases";
      readonly keys: readonly Scene[];
      readonly size: Viewport;
      readonly frames: number;
      readonly framesPerSecond: number;
      /** How often all phases of the scan are played. */
      readonly phaseCycles: number;
      readonly error: number;
    }
  | { readonly kind: "picture"; readonly keys: readonly Scene[]; readonly size: Viewport; readonly error: number }
);

const paths = { turntable: VideoPath.TURNTABLE, tour: VideoPath.TOUR, phases: VideoPath.STANDING } as const;

/** Returns the messages that order the file, in order. */
export function encodeFile(order: FileOrder): Bytes[] {
  const { size, error } = order;
  const keys = order.keys.map((scene, index) =>
    encoded({ case: "keyView", value: create(KeyViewSchema, { index, scene }) }),
  );
  const kind =
    order.kind === "picture"
      ? ({ case: "picture", value: create(LargePictureSchema, { ...size, error }) } as const)
      : ({
          case: "video",
          value: create(VideoSchema, {
            ...size,
            error,
            path: paths[order.kind],
            frames: order.frames,
            framesPerSecond: order.framesPerSecond,
            phaseCycles: order.phaseCycles,
          }),
        } as const);
  const marks = (order.marks?.items ?? []).map(({ mark, label }) => encodeFileMark(mark, label));
  const request = create(FileRequestSchema, { kind, markUnit: order.marks?.unit ?? 0 });
  return [...keys, ...marks, encoded({ case: "file", value: request })];
}

/** Encodes a mark with its text as an image, because the worker has no fonts. */
const encodeFileMark = (mark: Mark, label: MarkLabel | null): Bytes =>
  encoded({
    case: "fileMark",
    value: create(FileMarkSchema, {
      mark: messageOf({ ...mark, text: "" }),
      ...(label ? { label: create(FileMark_LabelSchema, label) } : {}),
    }),
  });

export const encodeFileTaken = (seq: bigint): Bytes =>
  encoded({ case: "fileTaken", value: create(FileTakenSchema, { seq }) });

export const encodeKernelQuery = (): Bytes => encoded({ case: "kernel", value: create(KernelQuerySchema) });
export const encodeCurveQuery = (): Bytes => encoded({ case: "errorCurve", value: create(ErrorCurveQuerySchema) });
export const encodeGoodViewsQuery = (): Bytes => encoded({ case: "goodViews", value: create(GoodViewsQuerySchema) });
