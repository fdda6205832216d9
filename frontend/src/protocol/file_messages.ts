import { create, toBinary } from "@bufbuild/protobuf";
import {
  ClientMessageSchema,
  ErrorCurveQuerySchema,
  Video_Path as VideoPath,
  FileRequestSchema,
  FileTakenSchema,
  VideoSchema,
  KernelQuerySchema,
  KeyViewSchema,
  LargePictureSchema,
  type ClientMessage,
} from "./gen/api/proto/stream_pb";
import type { Scene, Viewport } from "./messages";

export { KernelReport_Origin as KernelOrigin } from "./gen/api/proto/stream_pb";
export type { ErrorCurve, FilePart, KernelReport } from "./gen/api/proto/stream_pb";

type Bytes = Uint8Array<ArrayBuffer>;
const encoded = (body: ClientMessage["body"]): Bytes =>
  toBinary(ClientMessageSchema, create(ClientMessageSchema, { body }));

/**
 * The content of a file that a worker creates. `error` is the estimated error at which a frame or a band is finished.
 */
export type FileOrder =
  | {
      readonly kind: "turntable" | "tour";
      readonly keys: readonly Scene[];
      readonly size: Viewport;
      readonly frames: number;
      readonly framesPerSecond: number;
      readonly error: number;
    }
  | { readonly kind: "picture"; readonly keys: readonly Scene[]; readonly size: Viewport; readonly error: number };

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
            path: order.kind === "tour" ? VideoPath.TOUR : VideoPath.TURNTABLE,
            frames: order.frames,
            framesPerSecond: order.framesPerSecond,
          }),
        } as const);
  return [...keys, encoded({ case: "file", value: create(FileRequestSchema, { kind }) })];
}

export const encodeFileTaken = (seq: bigint): Bytes =>
  encoded({ case: "fileTaken", value: create(FileTakenSchema, { seq }) });

export const encodeKernelQuery = (): Bytes => encoded({ case: "kernel", value: create(KernelQuerySchema) });
export const encodeCurveQuery = (): Bytes => encoded({ case: "errorCurve", value: create(ErrorCurveQuerySchema) });
