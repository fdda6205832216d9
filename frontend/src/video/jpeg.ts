import { pictureOf, type CodedPicture, type FrameDecoder, type Picture } from "./picture";

/** Decodes JPEG with the browser's own image decoder, which exists everywhere. */
export class JpegDecoder implements FrameDecoder {
  readonly independent = true;

  async decode(frame: CodedPicture): Promise<Picture> {
    const data = frame.data as Uint8Array<ArrayBuffer>;
    return pictureOf(await createImageBitmap(new Blob([data], { type: "image/jpeg" })));
  }

  close(): void {
    // There is nothing to release.
  }
}
