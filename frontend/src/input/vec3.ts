/** A point or direction in world space: millimetres, the patient's axes (x left, y back, z head). */
export interface Vec3 {
  readonly x: number;
  readonly y: number;
  readonly z: number;
}

export const vec3 = (x: number, y: number, z: number): Vec3 => ({ x, y, z });
export const add = (a: Vec3, b: Vec3): Vec3 => vec3(a.x + b.x, a.y + b.y, a.z + b.z);
export const subtract = (a: Vec3, b: Vec3): Vec3 => vec3(a.x - b.x, a.y - b.y, a.z - b.z);
export const scale = (a: Vec3, s: number): Vec3 => vec3(a.x * s, a.y * s, a.z * s);
export const dot = (a: Vec3, b: Vec3): number => a.x * b.x + a.y * b.y + a.z * b.z;
export const cross = (a: Vec3, b: Vec3): Vec3 =>
  vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
export const length = (a: Vec3): number => Math.hypot(a.x, a.y, a.z);

/** Returns the direction of `a`, or `otherwise` if `a` is zero. */
export function normalize(a: Vec3, otherwise: Vec3): Vec3 {
  const n = length(a);
  return n > 1e-12 && Number.isFinite(n) ? scale(a, 1 / n) : otherwise;
}

// Type guards for values from the browser's storage, which may be damaged.
export const isNumber = (value: unknown): value is number => typeof value === "number" && Number.isFinite(value);

export function isPoint(value: unknown): value is Vec3 {
  const point = value as Partial<Record<"x" | "y" | "z", unknown>> | null;
  return typeof point === "object" && point !== null && isNumber(point.x) && isNumber(point.y) && isNumber(point.z);
}
