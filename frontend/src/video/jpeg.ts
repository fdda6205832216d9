import { pictureOf, type CodedPicture, type FrameDecoder, type Picture } from "./picture";

/** The browser's own decoder of pictures: everywhere. */
export class JpegDecoder implements FrameDecoder {
  readonly independent = true;

  async decode(frame: CodedPicture): Promise<Picture> {
    const data = frame.data as Uint8Array<ArrayBuffer>;
    return pictureOf(await createImageBitmap(new Blob([data], { type: "image/jpeg" })));
  }

  close(): void {
    // Nothing is kept.
  }
}
