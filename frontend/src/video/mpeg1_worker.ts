import JSMpeg, { type Mpeg1Video } from "@cycjimmy/jsmpeg-player";
import { yuvToRgba } from "./yuv";

/** MPEG-1 in software, outside the page's main thread. Answers each order once, in order. */

export interface Mpeg1Order {
  readonly key: boolean;
  readonly data: Uint8Array<ArrayBuffer>;
  readonly width: number;
  readonly height: number;
}
/** The picture, or null if the frame could not be decoded. */
export type Mpeg1Answer = ImageBitmap | null;

// jsmpeg reads its clock from `window`, which a worker lacks.
(globalThis as { window?: unknown }).window ??= globalThis;

/** Enough for a key frame of the largest picture. Data beyond this is lost. */
const bufferBytes = 8 << 20;
/**
 * Maximum number of start codes to read for a picture, which at most a sequence header and a group
 * header precede.
 */
const mostStartCodes = 4;

let decoder: Mpeg1Video | null = null;
/** The buffer that `render` fills. */
const target: { rgba: Uint8ClampedArray<ArrayBuffer> | null; width: number; height: number } = {
  rgba: null,
  width: 0,
  height: 0,
};

function newDecoder(): Mpeg1Video {
  const made = new JSMpeg.Decoder.MPEG1Video({ streaming: true, videoBufferSize: bufferBytes });
  made.connect({
    resize: () => undefined,
    render: (y, cr, cb) => {
      target.rgba = new Uint8ClampedArray(4 * target.width * target.height);
      yuvToRgba(y, cr, cb, made.codedWidth, target.width, target.height, target.rgba);
    },
  });
  return made;
}

async function decode(order: Mpeg1Order): Promise<Mpeg1Answer> {
  // jsmpeg reads only the sequence header of its first picture.
  if (order.key) decoder = newDecoder();
  if (!decoder) return null;
  Object.assign(target, { rgba: null, width: order.width, height: order.height });
  decoder.write(0, order.data);
  for (let n = 0; n < mostStartCodes && !target.rgba; n++) decoder.decode();
  return target.rgba && createImageBitmap(new ImageData(target.rgba, order.width, order.height));
}

let before = Promise.resolve();
onmessage = ({ data }: MessageEvent<Mpeg1Order>) => {
  before = before.then(async () => {
    const answer = await decode(data).catch(() => null);
    postMessage(answer, { transfer: answer ? [answer] : [] });
  });
};
