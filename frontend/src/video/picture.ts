import type { Frame } from "../protocol/messages";

/** A decoded picture; `close` gives its memory back. */
export interface Picture {
  readonly image: CanvasImageSource;
  /** In pixels, of what is to be shown. */
  readonly width: number;
  readonly height: number;
  close(): void;
}

/** What a decoder needs of a frame. */
export type CodedPicture = Pick<Frame, "codec" | "key" | "seq" | "data" | "decoder" | "width" | "height">;

/** Turns coded frames into pictures, one for each, in the order given. */
export interface FrameDecoder<P = Picture> {
  /** Each frame stands alone, so any of them may be left out; else none may be, from a key frame on. */
  readonly independent: boolean;
  /** Rejects on a damaged frame; a chained decoder is good for nothing then, and another is made. */
  decode(frame: CodedPicture): Promise<P>;
  /** What is under way rejects. */
  close(): void;
}

export function pictureOf(bitmap: ImageBitmap): Picture {
  return { image: bitmap, width: bitmap.width, height: bitmap.height, close: () => bitmap.close() };
}
