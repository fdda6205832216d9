import { add, dot, length, scale, subtract, vec3, type Vec3 } from "../input/vec3";

export const planes = ["axial", "sagittal", "coronal"] as const;
export type Plane = (typeof planes)[number];

/** The slices along one of the patient's axes, placed as the server specifies (docs/adr/0026), in mm. */
export interface Stack {
  readonly plane: Plane;
  readonly columns: number;
  readonly rows: number;
  readonly slices: number;
  /** The centre of the top left pixel of the first slice. */
  readonly first: Vec3;
  /** Steps to the next pixel and to the next slice, each along one of the patient's axes. */
  readonly right: Vec3;
  readonly down: Vec3;
  readonly next: Vec3;
  /** Absent if the slices are stored ones along the patient's axes. */
  readonly oblique?: Oblique;
}

/** The pixels of slices, whatever plane they show. */
export type Grid = Omit<Stack, "plane">;

/** What is known of slices in another direction, or with a thickness. */
export interface Oblique {
  /** A number that identifies the direction and the slab. */
  readonly id: number;
  readonly slab: { readonly mm: number; readonly projection: "mean" | "maximum" | "minimum" };
  /** The size in mm that fits the view at zoom 1. */
  readonly fit: { readonly width: number; readonly height: number };
}

/** The value of a clipped slice where nothing is shown. */
export const blank = -32768;

/** A position in pixels and slices. 0 is the centre of the first one. */
export interface Spot {
  readonly column: number;
  readonly row: number;
  readonly slice: number;
}

const along = (vector: Vec3, fromFirst: Vec3): number => dot(fromFirst, vector) / dot(vector, vector);

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

const nearestIndex = (n: number, count: number): number => Math.min(count - 1, Math.max(0, Math.round(n)));

/** Returns the pixel and the slice that contain a point, or the nearest ones. */
export function pixelOf(stack: Stack, place: Vec3): Spot {
  const spot = spotOf(stack, place);
  return {
    column: nearestIndex(spot.column, stack.columns),
    row: nearestIndex(spot.row, stack.rows),
    slice: nearestIndex(spot.slice, stack.slices),
  };
}

/** Returns the index of a point's pixel in the values of its slice. */
export function offsetOf(stack: Stack, place: Vec3): number {
  const { column, row } = pixelOf(stack, place);
  return row * stack.columns + column;
}

/** Returns the same point in another slice of the stack, limited to the existing slices. */
export function inSlice(stack: Stack, place: Vec3, slice: number): Vec3 {
  return placeOf(stack, { ...spotOf(stack, place), slice: nearestIndex(slice, stack.slices) });
}

/** Returns the centre of the pixel that is nearest to a point. */
export const heldWithin = (stack: Stack, place: Vec3): Vec3 => placeOf(stack, pixelOf(stack, place));

/** Returns the size of a pixel and the distance of the slices in mm. */
export const pixelSize = (
  stack: Grid,
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

/** Returns the side of the patient towards which a direction along a patient axis points. */
export function sideOf(vector: Vec3): string {
  const parts = [vector.x, vector.y, vector.z];
  const axis = parts.reduce((best, part, i) => (Math.abs(part) > Math.abs(parts[best] ?? 0) ? i : best), 0);
  return sides[axis]?.[(parts[axis] ?? 0) > 0 ? 1 : 0] ?? "";
}

/** The smallest part of a direction that gets a letter, which is that of 22.5 degrees. */
const leastPart = Math.sin(Math.PI / 8);

/** Returns the letters of an oblique direction, the largest part first. */
export function sidesOf(vector: Vec3): string {
  const parts = [vec3(vector.x, 0, 0), vec3(0, vector.y, 0), vec3(0, 0, vector.z)];
  return parts
    .filter((part) => length(part) >= leastPart * length(vector))
    .sort((a, b) => length(b) - length(a))
    .map(sideOf)
    .join("");
}

/** Returns the letters for the edges of the picture. */
export const edgesOf = (stack: Stack) => ({
  right: sidesOf(stack.right),
  left: sidesOf(scale(stack.right, -1)),
  bottom: sidesOf(stack.down),
  top: sidesOf(scale(stack.down, -1)),
});

/** Returns a point as a side and a distance from the middle in mm, per axis. */
export const placeParts = (place: Vec3): readonly { readonly side: string; readonly mm: number }[] =>
  [vec3(place.x, 0, 0), vec3(0, place.y, 0), vec3(0, 0, place.z)].map((part) => ({
    side: sideOf(part),
    mm: length(part),
  }));

interface Box {
  readonly size: readonly number[];
  readonly spacing: readonly number[];
  /** Nine numbers, row-major. The columns are the voxel axes. */
  readonly direction: readonly number[];
}

/** Whether a point is inside the volume. An oblique volume leaves corners of its slices empty. */
export function isInside({ size, spacing, direction }: Box, place: Vec3): boolean {
  return [0, 1, 2].every((axis) => {
    const vector = vec3(direction[axis] ?? 0, direction[3 + axis] ?? 0, direction[6 + axis] ?? 0);
    return Math.abs(dot(vector, place)) <= ((size[axis] ?? 0) * (spacing[axis] ?? 0)) / 2 + 1e-6;
  });
}
