import {
  fitted,
  ownTextureSide,
  texturePixels,
  type Pixels,
  type TextureFiles,
  type TextureName,
} from "../../../scene/textures";

type Bytes = Uint8Array<ArrayBuffer>;

async function coded(canvas: OffscreenCanvas, type: "image/png" | "image/jpeg", quality?: number): Promise<Bytes> {
  const blob = await canvas.convertToBlob({ type, ...(quality === undefined ? {} : { quality }) });
  return new Uint8Array(await blob.arrayBuffer());
}

function painted({ width, height, rgba }: Pixels): OffscreenCanvas {
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d")?.putImageData(new ImageData(rgba, width, height), 0, 0);
  return canvas;
}

export const pngOf = (pixels: Pixels): Promise<Bytes> => coded(painted(pixels), "image/png");

const made = new Map<TextureName, Promise<Bytes>>();

/** Encodes a pattern as a PNG file. The bytes are the same each time and identify the pattern. */
export function textureFile(name: TextureName): Promise<Bytes> {
  const file = made.get(name) ?? pngOf(texturePixels(name));
  made.set(name, file);
  return file;
}

/** Returns the files of these patterns. */
export const textureFiles = async (names: readonly TextureName[]): Promise<TextureFiles> =>
  new Map(await Promise.all(names.map(async (name) => [name, await textureFile(name)] as const)));

export type ReadPicture = { readonly bytes: Bytes } | { readonly refused: "too_large" | "no_picture" };

const mostFileBytes = 30_000_000;

/** Reads the user's file as a small JPEG. Only the picture is used, without the file name or the camera's metadata. */
export async function readPicture(file: Blob): Promise<ReadPicture> {
  if (file.size > mostFileBytes) return { refused: "too_large" };
  let bitmap: ImageBitmap;
  try {
    bitmap = await createImageBitmap(file);
  } catch {
    return { refused: "no_picture" };
  }
  const { width, height } = fitted(bitmap.width, bitmap.height, ownTextureSide);
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d");
  if (!context) return { refused: "no_picture" };
  context.imageSmoothingQuality = "high";
  context.drawImage(bitmap, 0, 0, width, height);
  bitmap.close();
  return { bytes: await coded(canvas, "image/jpeg", 0.8) };
}
