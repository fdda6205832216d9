import { StillFormat, type Still } from "../protocol/messages";
import { test_left, test_right, test_still } from "./test_frames";

const types: Partial<Record<StillFormat, string>> = { [StillFormat.PNG]: "image/png", [StillFormat.WEBP]: "image/webp" };

/** The pixels as they were stored: no colour profile, no opacity has a part in them. */
export async function decode_still(still: Pick<Still, "data" | "format">): Promise<Uint8ClampedArray<ArrayBuffer>> {
  const type = types[still.format];
  if (type === undefined) throw new Error("a still picture of an unknown format");
  const blob = new Blob([still.data as Uint8Array<ArrayBuffer>], { type });
  const bitmap = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
  const { width, height } = bitmap;
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  if (!context) throw new Error("this browser gives no canvas");
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  return context.getImageData(0, 0, width, height).data;
}

/** The formats whose pixels this browser gives back exactly, the smaller first. Some guard a canvas with noise: none. */
export async function probe_stills(): Promise<StillFormat[]> {
  const formats = [
    { format: StillFormat.WEBP, data: test_still.webp() },
    { format: StillFormat.PNG, data: test_still.png() },
  ];
  const exact = await Promise.all(formats.map(gives_back_exactly));
  return formats.filter((_, n) => exact[n]).map(({ format }) => format);
}

async function gives_back_exactly(still: Pick<Still, "data" | "format">): Promise<boolean> {
  const row = [test_left, test_left, test_right, test_right].flatMap((colour) => [...colour, 255]);
  const right = Array.from({ length: test_still.height }, () => row).flat();
  try {
    const rgba = await decode_still(still);
    return rgba.length === right.length && rgba.every((level, n) => level === right[n]);
  } catch {
    return false;
  }
}
