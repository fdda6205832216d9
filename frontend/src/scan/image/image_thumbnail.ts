import { draw } from "../thumbnail";
import type { Thumbnail } from "../types";
import { lengths } from "./canonical";
import type { ImageHeader, Triple, VoxelType } from "./header";

type Reader = (view: DataView, at: number, little: boolean) => number;

const readers: Readonly<Record<VoxelType, { readonly bytes: number; readonly read: Reader }>> = {
  int8: { bytes: 1, read: (view, at) => view.getInt8(at) },
  uint8: { bytes: 1, read: (view, at) => view.getUint8(at) },
  int16: { bytes: 2, read: (view, at, little) => view.getInt16(at, little) },
  uint16: { bytes: 2, read: (view, at, little) => view.getUint16(at, little) },
  int32: { bytes: 4, read: (view, at, little) => view.getInt32(at, little) },
  uint32: { bytes: 4, read: (view, at, little) => view.getUint32(at, little) },
  float32: { bytes: 4, read: (view, at, little) => view.getFloat32(at, little) },
  float64: { bytes: 8, read: (view, at, little) => view.getFloat64(at, little) },
};

/** Draws one slice as radiologists see it: the patient's left on the right, or the front on the left, and the head up. */
export function drawImageThumbnail(image: ImageHeader & { readonly type: VoxelType }, slice: ArrayBuffer): Thumbnail {
  const { bytes, read } = readers[image.type];
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
