import { Codec } from "../protocol/messages";
import { H264Decoder } from "./h264";
import { JpegDecoder } from "./jpeg";
import { Mpeg1Decoder } from "./mpeg1";
import type { CodedPicture, FrameDecoder } from "./picture";
import { testH264, testJpeg, testLeft, testMpeg1, testRight, type Rgb } from "./test_frames";

/** The codecs in the order in which they are announced, the best first. */
export const ladder: readonly Codec[] = [Codec.H264, Codec.JPEG, Codec.MPEG1];

/** Creates a decoder. Returns null for a codec that is unknown or that this browser lacks. */
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
 * Returns the codecs that this browser has decoded a test frame with in the right colours. MPEG-1, whose decoder must
 * be loaded first, is tested only without H.264 or if `only` contains it.
 */
export async function probeCodecs(only: readonly Codec[] | null = null): Promise<Codec[]> {
  const tried = (codec: Codec) => (!only || only.includes(codec) ? decodes(codec) : Promise.resolve(false));
  const [h264, jpeg] = await Promise.all([tried(Codec.H264), tried(Codec.JPEG)]);
  const mpeg1 = (only?.includes(Codec.MPEG1) ?? !h264) && (await decodes(Codec.MPEG1));
  return ladder.filter((codec) => (codec === Codec.H264 ? h264 : codec === Codec.JPEG ? jpeg : mpeg1));
}

/**
 * Returns the codecs that `localStorage` names for measurements and debugging, such as "JPEG" or
 * "H264,MPEG1". Null for all codecs.
 */
export function chosenCodecs(storage: Pick<Storage, "getItem">): Codec[] | null {
  const names = storage.getItem("diaphane.codecs")?.split(",") ?? [];
  const chosen = ladder.filter((codec) => names.includes(Codec[codec]));
  return chosen.length > 0 ? chosen : null;
}

/**
 * Time limit of a test, after which the next codec is tested, because a broken driver may never
 * respond. The browser's own JPEG decoder always responds.
 */
const probeLimitMs = 3000;
/**
 * Tolerated difference out of 255, due to coding, 4:2:0 and rounding. A wrong matrix or range
 * differs by 10 or more.
 */
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
