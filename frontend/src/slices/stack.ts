import { add, dot, length, scale, subtract, vec3, type Vec3 } from "../input/vec3";

export const planes = ["axial", "sagittal", "coronal"] as const;
export type Plane = (typeof planes)[number];

/** The slices across one of the patient's axes, as the server says where they lie (docs/adr/0026). mm. */
export interface Stack {
  readonly plane: Plane;
  readonly columns: number;
  readonly rows: number;
  readonly slices: number;
  /** The centre of the first slice's upper left pixel. */
  readonly first: Vec3;
  /** From a pixel to the next, and from a slice to the next; each along one axis of the patient. */
  readonly right: Vec3;
  readonly down: Vec3;
  readonly next: Vec3;
}

/** In pixels and slices, 0 at the centre of the first. */
export interface Spot {
  readonly column: number;
  readonly row: number;
  readonly slice: number;
}

const along = (way: Vec3, fromFirst: Vec3): number => dot(fromFirst, way) / dot(way, way);

export function spotOf(stack: Stack, place: Vec3): Spot {
  const fromFirst = subtract(place, stack.first);
  return {
    column: along(stack.right, fromFirst),
    row: along(stack.down, fromFirst),
    slice: along(stack.next, fromFirst),
  };
}

export function placeOf(stack: Stack, { column, row, slice }: Spot): Vec3 {
  return add(add(stack.first, scale(stack.right, column)), add(scale(stack.down, row), scale(stack.next, slice)));
}

const whole = (n: number, count: number): number => Math.min(count - 1, Math.max(0, Math.round(n)));

/** The pixel and the slice that a place lies in; the nearest where it lies in none. */
export function pixelOf(stack: Stack, place: Vec3): Spot {
  const spot = spotOf(stack, place);
  return {
    column: whole(spot.column, stack.columns),
    row: whole(spot.row, stack.rows),
    slice: whole(spot.slice, stack.slices),
  };
}

/** The same place in the middle of another slice of the stack; beyond the last one the last. */
export function inSlice(stack: Stack, place: Vec3, slice: number): Vec3 {
  return placeOf(stack, { ...spotOf(stack, place), slice: whole(slice, stack.slices) });
}

/** As near as the stack has a pixel. */
export const heldWithin = (stack: Stack, place: Vec3): Vec3 => placeOf(stack, pixelOf(stack, place));

/** mm. */
export const pixelSize = (
  stack: Stack,
): { readonly width: number; readonly height: number; readonly thickness: number } => ({
  width: length(stack.right),
  height: length(stack.down),
  thickness: length(stack.next),
});

const sides = [
  ["R", "L"],
  ["A", "P"],
  ["I", "S"],
] as const;

/** To which side of the patient a direction along one of his axes goes. */
export function sideOf(way: Vec3): string {
  const parts = [way.x, way.y, way.z];
  const axis = parts.reduce((best, part, i) => (Math.abs(part) > Math.abs(parts[best] ?? 0) ? i : best), 0);
  return sides[axis]?.[(parts[axis] ?? 0) > 0 ? 1 : 0] ?? "";
}

/** What lies at the edges of the picture. */
export const edgesOf = (stack: Stack) => ({
  right: sideOf(stack.right),
  left: sideOf(scale(stack.right, -1)),
  bottom: sideOf(stack.down),
  top: sideOf(scale(stack.down, -1)),
});

/** A place as it is said: to which side of the middle, and how far in mm. */
export const saidPlace = (place: Vec3): readonly { readonly side: string; readonly mm: number }[] =>
  [vec3(place.x, 0, 0), vec3(0, place.y, 0), vec3(0, 0, place.z)].map((part) => ({
    side: sideOf(part),
    mm: length(part),
  }));

interface Box {
  readonly size: readonly number[];
  readonly spacing: readonly number[];
  /** 9, row-major, columns are the voxels' axes. */
  readonly direction: readonly number[];
}

/** Whether a place lies in the volume: an oblique one leaves corners of its slices empty. */
export function isInside({ size, spacing, direction }: Box, place: Vec3): boolean {
  return [0, 1, 2].every((axis) => {
    const way = vec3(direction[axis] ?? 0, direction[3 + axis] ?? 0, direction[6 + axis] ?? 0);
    return Math.abs(dot(way, place)) <= ((size[axis] ?? 0) * (spacing[axis] ?? 0)) / 2 + 1e-6;
  });
}
