import { draw } from "../thumbnail";
import type { Thumbnail } from "../types";
import { bytesOf, lengths, type ImageHeader, type Triple, type VoxelType } from "./header";

type Reader = (view: DataView, at: number, little: boolean) => number;

const readers: Readonly<Record<VoxelType, Reader>> = {
  int8: (view, at) => view.getInt8(at),
  uint8: (view, at) => view.getUint8(at),
  int16: (view, at, little) => view.getInt16(at, little),
  uint16: (view, at, little) => view.getUint16(at, little),
  int32: (view, at, little) => view.getInt32(at, little),
  uint32: (view, at, little) => view.getUint32(at, little),
  float32: (view, at, little) => view.getFloat32(at, little),
  float64: (view, at, little) => view.getFloat64(at, little),
};

/** Draws one slice as radiologists see it: the patient's left on the right, or the front on the left, and the head up. */
export function drawImageThumbnail(image: ImageHeader & { readonly type: VoxelType }, slice: ArrayBuffer): Thumbnail {
  const read = readers[image.type];
  const bytes = bytesOf[image.type];
  const view = new DataView(slice);
  const [columns, rows] = image.size;
  const [wide, tall] = image.axes ? lengths(image.axes) : image.spacing;
  const x: Triple = image.axes?.[0] ?? [1, 0, 0];
  const y: Triple = image.axes?.[1] ?? [0, 1, 0];
  const upright = mainAxis(x) === 2; // then the rows of the file run along the body
  const flipX = runsBackwards(x);
  const flipY = runsBackwards(y);
  const value = (column: number, row: number) => {
    const at = (flipX ? columns - 1 - column : column) + columns * (flipY ? rows - 1 - row : row);
    const found = read(view, bytes * at, image.littleEndian);
    return Number.isFinite(found) ? found : 0;
  };
  return upright
    ? draw({ columns: rows, rows: columns, wide: tall, tall: wide }, (column, row) => value(row, column))
    : draw({ columns, rows, wide, tall }, value);
}

const mainAxis = (axis: Triple): number => {
  const sizes = axis.map(Math.abs);
  return sizes.indexOf(Math.max(...sizes));
};

/** Whether an axis runs to the right, to the front or to the head, and so against the direction of the screen. */
function runsBackwards(axis: Triple): boolean {
  const main = mainAxis(axis);
  return (axis[main] ?? 0) < 0 !== (main === 2);
}
