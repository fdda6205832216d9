import { Codec } from "../protocol/messages";
import { H264Decoder } from "./h264";
import { JpegDecoder } from "./jpeg";
import { Mpeg1Decoder } from "./mpeg1";
import type { CodedPicture, FrameDecoder } from "./picture";
import { testH264, testJpeg, testLeft, testMpeg1, testRight, type Rgb } from "./test_frames";

/** Best first: the order in which they are announced. */
export const ladder: readonly Codec[] = [Codec.H264, Codec.JPEG, Codec.MPEG1];

/** Nothing for a codec that this page does not know. */
export function makeDecoder(codec: Codec): FrameDecoder | null {
  switch (codec) {
    case Codec.H264:
      return H264Decoder.exists() ? new H264Decoder() : null;
    case Codec.JPEG:
      return new JpegDecoder();
    case Codec.MPEG1:
      return new Mpeg1Decoder();
    default:
      return null;
  }
}

/**
 * The codecs that this browser really decodes: each has shown a test frame in its right colours. MPEG-1, whose decoder
 * must be loaded first, is tried only where there is no H.264, or when it is asked for by `only`.
 */
export async function probeCodecs(only: readonly Codec[] | null = null): Promise<Codec[]> {
  const tried = (codec: Codec) => (!only || only.includes(codec) ? decodes(codec) : Promise.resolve(false));
  const [h264, jpeg] = await Promise.all([tried(Codec.H264), tried(Codec.JPEG)]);
  const mpeg1 = (only?.includes(Codec.MPEG1) ?? !h264) && (await decodes(Codec.MPEG1));
  return ladder.filter((codec) => (codec === Codec.H264 ? h264 : codec === Codec.JPEG ? jpeg : mpeg1));
}

/** For whoever measures or mends: names of codecs in `localStorage`, as "JPEG" or "H264,MPEG1"; nothing: all. */
export function chosenCodecs(storage: Pick<Storage, "getItem">): Codec[] | null {
  const names = storage.getItem("diaphane.codecs")?.split(",") ?? [];
  const chosen = ladder.filter((codec) => names.includes(Codec[codec]));
  return chosen.length > 0 ? chosen : null;
}

/** A broken driver may say nothing at all; then there is the next codec. The browser's own JPEG always answers. */
const probeLimitMs = 3000;
/** Of 255: coding, 4:2:0 and rounding. A wrong matrix or range is off by 10 and more. */
const colourTolerance = 6;

const testFrame = (codec: Codec): CodedPicture | null => {
  const frame = { codec, key: true, seq: 1n, decoder: "" };
  switch (codec) {
    case Codec.H264:
      return {
        ...frame,
        decoder: testH264.decoder,
        width: testH264.side,
        height: testH264.side,
        data: testH264.data(),
      };
    case Codec.JPEG:
      return { ...frame, width: testJpeg.side, height: testJpeg.side, data: testJpeg.data() };
    case Codec.MPEG1:
      return { ...frame, width: testMpeg1.side, height: testMpeg1.side, data: testMpeg1.data() };
    default:
      return null;
  }
};

async function decodes(codec: Codec): Promise<boolean> {
  const frame = testFrame(codec);
  let decoder: FrameDecoder | null = null;
  let timer: ReturnType<typeof setTimeout> | undefined;
  try {
    decoder = makeDecoder(codec);
    if (!decoder || !frame) return false;
    const tooLong = new Promise<never>((_, reject) => {
      if (codec !== Codec.JPEG) timer = setTimeout(() => reject(new Error("too long")), probeLimitMs);
    });
    const picture = await Promise.race([decoder.decode(frame), tooLong]);
    const { width, height } = picture;
    const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
    context?.drawImage(picture.image, 0, 0);
    picture.close();
    const at = (x: number) => context?.getImageData(x, height >> 1, 1, 1).data ?? [];
    return (
      width === frame.width &&
      height === frame.height &&
      isLike(at(width >> 2), testLeft) &&
      isLike(at((3 * width) >> 2), testRight)
    );
  } catch {
    return false;
  } finally {
    clearTimeout(timer);
    decoder?.close();
  }
}

const isLike = (pixel: ArrayLike<number>, colour: Rgb): boolean =>
  colour.every((level, n) => Math.abs((pixel[n] ?? -1) - level) <= colourTolerance);
