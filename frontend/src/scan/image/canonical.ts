import { bytesOf, fromRas, lengths, type ImageHeader, type VoxelType } from "./header";
import { typeCodes } from "./nifti";

/** Length of a NIfTI-1 header with the four bytes that say that no extension follows. */
const length = 352;
/** Offsets of the number of dimensions, of the number of volumes, and of the time from volume to volume. */
const dimensionsAt = 40;
const volumesAt = 48;
const stepAt = 92;
/** Units of NIfTI. */
const mm = 2;
const ms = 16;

/**
 * Returns the header of the NIfTI-1 file that is uploaded (ingest/build/nifti.h): geometry, type,
 * scale and modality. Nothing of the original header is copied, because its texts may name the
 * patient.
 */
export function canonicalHeader(image: ImageHeader & { readonly type: VoxelType }): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(length);
  const view = new DataView(bytes.buffer);
  const little = image.littleEndian;
  const shorts = (at: number, values: readonly number[]) =>
    values.forEach((value, i) => view.setInt16(at + 2 * i, value, little));
  const floats = (at: number, values: readonly number[]) =>
    values.forEach((value, i) => view.setFloat32(at + 4 * i, value, little));
  const text = (at: number, value: string) => bytes.set(new TextEncoder().encode(value), at);
  view.setInt32(0, 348, little);
  const { volumes, stepMs } = image;
  shorts(dimensionsAt, [volumes > 1 ? 4 : 3, ...image.size, volumes, 1, 1, 1]);
  shorts(70, [typeCodes[image.type], 8 * bytesOf[image.type]]);
  floats(76, [1, ...(image.axes ? lengths(image.axes) : image.spacing), stepMs ?? 0]);
  floats(108, [length, image.slope, image.intercept]);
  view.setUint8(123, stepMs === null ? mm : mm | ms);
  if (image.axes) {
    shorts(254, [1]);
    const [x, y, z] = [fromRas(image.axes[0]), fromRas(image.axes[1]), fromRas(image.axes[2])];
    const origin = fromRas(image.origin ?? [0, 0, 0]);
    [0, 1, 2].forEach((row) => floats(280 + 16 * row, [x[row] ?? 0, y[row] ?? 0, z[row] ?? 0, origin[row] ?? 0]));
  }
  text(328, image.modality);
  text(344, "n+1");
  return bytes;
}

/** Returns the header of the same file with only `volumes` volumes, of which each is the `every`th of the others. */
export function withVolumes(header: Uint8Array, volumes: number, every: number): Uint8Array<ArrayBuffer> {
  const bytes = Uint8Array.from(header);
  const view = new DataView(bytes.buffer);
  const little = view.getInt32(0, true) === 348;
  view.setInt16(dimensionsAt, volumes > 1 ? 4 : 3, little);
  view.setInt16(volumesAt, volumes, little);
  view.setFloat32(stepAt, view.getFloat32(stepAt, little) * every, little);
  return bytes;
}
