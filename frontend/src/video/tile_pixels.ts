import { StillFormat, type Still } from "../protocol/messages";
import { testLeft, testRight, testStill } from "./test_frames";

const types: Partial<Record<StillFormat, string>> = {
  [StillFormat.PNG]: "image/png",
  [StillFormat.WEBP]: "image/webp",
};

/** Decodes the pixels exactly as stored, without colour profile or opacity. */
export async function decodeStill(still: Pick<Still, "data" | "format">): Promise<Uint8ClampedArray<ArrayBuffer>> {
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

/**
 * Returns the formats whose pixels this browser decodes exactly, the most compact first. Empty for browsers that add
 * noise to canvases.
 */
export async function probeStills(): Promise<StillFormat[]> {
  const formats = [
    { format: StillFormat.WEBP, data: testStill.webp() },
    { format: StillFormat.PNG, data: testStill.png() },
  ];
  const exact = await Promise.all(formats.map(givesBackExactly));
  return formats.filter((_, n) => exact[n]).map(({ format }) => format);
}

async function givesBackExactly(still: Pick<Still, "data" | "format">): Promise<boolean> {
  const row = [testLeft, testLeft, testRight, testRight].flatMap((colour) => [...colour, 255]);
  const right = Array.from({ length: testStill.height }, () => row).flat();
  try {
    const rgba = await decodeStill(still);
    return rgba.length === right.length && rgba.every((level, n) => level === right[n]);
  } catch {
    return false;
  }
}
