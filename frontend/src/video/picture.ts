import type { Frame } from "../protocol/messages";

/** A decoded picture. `close` releases its memory. */
export interface Picture {
  readonly image: CanvasImageSource;
  /** The size of the visible part in pixels. */
  readonly width: number;
  readonly height: number;
  close(): void;
}

/** The fields of a frame that a decoder needs. */
export type CodedPicture = Pick<Frame, "codec" | "key" | "seq" | "data" | "decoder" | "width" | "height">;

/** Decodes frames to pictures, one per frame, in the given order. */
export interface FrameDecoder<P = Picture> {
  /**
   * Whether each frame can be decoded on its own, so that any may be skipped. If not, none may be skipped after a key
   * frame.
   */
  readonly independent: boolean;
  /** Rejects on a damaged frame. A chained decoder is then unusable and must be replaced. */
  decode(frame: CodedPicture): Promise<P>;
  /** Rejects frames that are being decoded. */
  close(): void;
}

export function pictureOf(bitmap: ImageBitmap): Picture {
  return { image: bitmap, width: bitmap.width, height: bitmap.height, close: () => bitmap.close() };
}
