import { Codec } from "../protocol/messages";
import { H264Decoder } from "./h264";
import { JpegDecoder } from "./jpeg";
import { Mpeg1Decoder } from "./mpeg1";
import type { CodedPicture, FrameDecoder } from "./picture";
import { test_h264, test_jpeg, test_left, test_mpeg1, test_right, type Rgb } from "./test_frames";

/** Best first: the order in which they are announced. */
export const ladder: readonly Codec[] = [Codec.H264, Codec.JPEG, Codec.MPEG1];

/** Nothing for a codec that this page does not know. */
export function make_decoder(codec: Codec): FrameDecoder | null {
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
export async function probe_codecs(only: readonly Codec[] | null = null): Promise<Codec[]> {
  const tried = (codec: Codec) => (!only || only.includes(codec) ? decodes(codec) : Promise.resolve(false));
  const [h264, jpeg] = await Promise.all([tried(Codec.H264), tried(Codec.JPEG)]);
  const mpeg1 = (only?.includes(Codec.MPEG1) ?? !h264) && (await decodes(Codec.MPEG1));
  return ladder.filter((codec) => (codec === Codec.H264 ? h264 : codec === Codec.JPEG ? jpeg : mpeg1));
}

/** For whoever measures or mends: names of codecs in `localStorage`, as "JPEG" or "H264,MPEG1"; nothing: all. */
export function chosen_codecs(storage: Pick<Storage, "getItem">): Codec[] | null {
  const names = storage.getItem("diaphane.codecs")?.split(",") ?? [];
  const chosen = ladder.filter((codec) => names.includes(Codec[codec]));
  return chosen.length > 0 ? chosen : null;
}

/** A broken driver may say nothing at all; then there is the next codec. The browser's own JPEG always answers. */
const probe_limit_ms = 3000;
/** Of 255: coding, 4:2:0 and rounding. A wrong matrix or range is off by 10 and more. */
const colour_tolerance = 6;

const test_frame = (codec: Codec): CodedPicture | null => {
  const frame = { codec, key: true, seq: 1n, decoder: "" };
  switch (codec) {
    case Codec.H264:
      return { ...frame, decoder: test_h264.decoder, width: test_h264.side, height: test_h264.side, data: test_h264.data() };
    case Codec.JPEG:
      return { ...frame, width: test_jpeg.side, height: test_jpeg.side, data: test_jpeg.data() };
    case Codec.MPEG1:
      return { ...frame, width: test_mpeg1.side, height: test_mpeg1.side, data: test_mpeg1.data() };
    default:
      return null;
  }
};

async function decodes(codec: Codec): Promise<boolean> {
  const frame = test_frame(codec);
  let decoder: FrameDecoder | null = null;
  let timer: ReturnType<typeof setTimeout> | undefined;
  try {
    decoder = make_decoder(codec);
    if (!decoder || !frame) return false;
    const too_long = new Promise<never>((_, reject) => {
      if (codec !== Codec.JPEG) timer = setTimeout(() => reject(new Error("too long")), probe_limit_ms);
    });
    const picture = await Promise.race([decoder.decode(frame), too_long]);
    const { width, height } = picture;
    const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
    context?.drawImage(picture.image, 0, 0);
    picture.close();
    const at = (x: number) => context?.getImageData(x, height >> 1, 1, 1).data ?? [];
    return width === frame.width && height === frame.height && is_like(at(width >> 2), test_left) && is_like(at((3 * width) >> 2), test_right);
  } catch {
    return false;
  } finally {
    clearTimeout(timer);
    decoder?.close();
  }
}

const is_like = (pixel: ArrayLike<number>, colour: Rgb): boolean =>
  colour.every((level, n) => Math.abs((pixel[n] ?? -1) - level) <= colour_tolerance);
