import { computed, signal, type ReadonlySignal } from "@preact/signals";
import { add, isNumber, isPoint, length, scale, subtract, vec3, type Vec3 } from "../input/vec3";
import { clamp } from "../scene/numbers";
import { Curve, mostCurvePoints, turnedAcross } from "./curve";
import { mostSamples, mostSide, type Slab } from "./oblique";
import { wholeSlice, type Placing } from "./placing";
import { spotOf, type Grid, type Stack } from "./stack";

/** What is remembered of a curve: its points in mm in world space, and the straightened slice along it. */
export interface RememberedCurve {
  readonly points: readonly Vec3[];
  /** Degrees by which the slice is turned about the curve. */
  readonly angle: number;
  /** The size across the curve in mm. */
  readonly height: number;
}

export const angleLimits = { low: 0, high: 180 } as const;
export const heightLimits = { low: 2, high: 500 } as const;
/** Points that are closer in mm count as a double click. */
const leastStep = 0.01;
export const noCurve: RememberedCurve = { points: [], angle: 0, height: 60 };

/** A slice that is straightened along a curve, as the server samples it. */
export interface CurvedSlice {
  /** A number that identifies the curve, the angle and the slab. */
  readonly id: number;
  readonly points: readonly Vec3[];
  readonly angle: number;
  readonly slab: Slab;
  /** The distance of pixels in mm, in both directions. */
  readonly pixel: number;
  /** The pixels as a flat grid: x is the arc length, y the distance across the curve. */
  readonly grid: Grid;
}

/** A position in a straightened slice in pixels. */
export interface CurveSpot {
  readonly column: number;
  readonly row: number;
}

export interface CurveParts {
  readonly slab: ReadonlySignal<Slab>;
  /** The smallest distance of stored voxels in mm. */
  readonly spacing: () => number;
}

/** Returns the flat grid of a slice of this length and height, within the limits of the server. */
export function gridOf(long: number, height: number, spacing: number, slab: Slab): { pixel: number; grid: Grid } {
  const layers = slab.mm > 0 ? 1 + Math.ceil(slab.mm / spacing) : 1;
  const most = mostSide - 1;
  const pixel = Math.max(
    spacing,
    long / most,
    height / most,
    Math.sqrt((long * height * layers) / (0.9 * mostSamples)),
  );
  const columns = Math.floor(long / pixel) + 1;
  const rows = 2 * Math.floor(height / pixel / 2) + 1; // odd, so that the middle row lies on the curve
  const across = ((rows - 1) / 2) * pixel;
  const grid = {
    columns,
    rows,
    slices: 1,
    first: vec3(0, -across, 0),
    right: vec3(pixel, 0, 0),
    down: vec3(0, pixel, 0),
    next: vec3(0, 0, 1),
  };
  return { pixel, grid };
}

/** The curve that a viewer draws through the slices, and the view of the slice along it. */
export class CurveView {
  readonly points = signal<readonly Vec3[]>([]);
  readonly angle = signal(noCurve.angle);
  readonly height = signal(noCurve.height);
  /** The point that the pointer drags, by its index. */
  readonly held = signal<number | null>(null);
  /** The pixel under the pointer, or null while it is elsewhere. */
  readonly pointed = signal<CurveSpot | null>(null);
  /** Null while fewer than two points differ. */
  readonly path = computed(() => Curve.through(this.points.value));
  readonly slice = computed(() => this.shownSlice());
  private readonly moved = signal<Placing | null>(null);
  private readonly chosen = signal<{ readonly arc: number; readonly across: number } | null>(null);
  private id = 0;

  constructor(private readonly parts: CurveParts) {}

  get full(): boolean {
    return this.points.value.length >= mostCurvePoints;
  }

  /** Adds a point to the end of the curve, and lets the pointer drag it. */
  add(point: Vec3): void {
    const last = this.points.value.at(-1);
    if (this.full || (last && length(subtract(point, last)) < leastStep)) return;
    this.held.value = this.points.value.length;
    this.points.value = [...this.points.value, point];
  }

  /** Grabs the nearest point in a slice within `reach` mm of a place. Returns whether there is one. */
  hold(stack: Stack, index: number, place: Vec3, reach: number): boolean {
    const near = this.points.value
      .map((point, i) => ({ i, away: length(subtract(point, place)), spot: spotOf(stack, point) }))
      .filter(({ away, spot }) => away <= reach && Math.abs(spot.slice - index) <= 0.5)
      .sort((a, b) => a.away - b.away)[0];
    this.held.value = near?.i ?? null;
    return near !== undefined;
  }

  moveHeld(to: Vec3): void {
    this.points.value = this.points.value.map((point, i) => (i === this.held.value ? to : point));
  }

  undo(): void {
    this.held.value = null;
    this.points.value = this.points.value.slice(0, -1);
  }

  clear(): void {
    this.restore(noCurve);
  }

  setAngle(angle: number): void {
    this.angle.value = clamp(angle, angleLimits.low, angleLimits.high);
  }

  setHeight(height: number): void {
    this.moved.value = null;
    this.height.value = clamp(height, heightLimits.low, heightLimits.high);
  }

  placing(grid: Grid): Placing {
    return this.moved.value ?? wholeSlice(grid);
  }

  place(placing: Placing | null): void {
    this.moved.value = placing;
  }

  /** The pixel that keys move, which is the one that was pressed last, or the middle. */
  cursor({ grid, pixel }: CurvedSlice): CurveSpot {
    const { arc, across } = this.chosen.value ?? { arc: Infinity, across: 0 };
    const column = this.chosen.value ? arc / pixel : (grid.columns - 1) / 2;
    return heldSpot(grid, { column, row: across / pixel + (grid.rows - 1) / 2 });
  }

  choose({ grid, pixel }: CurvedSlice, spot: CurveSpot): void {
    const { column, row } = heldSpot(grid, spot);
    this.chosen.value = { arc: column * pixel, across: (row - (grid.rows - 1) / 2) * pixel };
  }

  /** Returns where a pixel lies in the volume, and the direction of the rows there. */
  placeOf({ grid, pixel, angle }: CurvedSlice, { column, row }: CurveSpot): { place: Vec3; down: Vec3 } | null {
    const frame = this.path.value?.at(column * pixel);
    if (!frame) return null;
    const down = turnedAcross(frame, angle);
    return { place: add(frame.place, scale(down, (row - (grid.rows - 1) / 2) * pixel)), down };
  }

  remembered(): RememberedCurve {
    return { points: this.points.value, angle: this.angle.value, height: this.height.value };
  }

  restore({ points, angle, height }: RememberedCurve): void {
    this.held.value = null;
    this.pointed.value = null;
    this.moved.value = null;
    this.chosen.value = null;
    this.points.value = points;
    this.angle.value = angle;
    this.height.value = height;
  }

  private shownSlice(): CurvedSlice | null {
    const path = this.path.value;
    if (!path) return null;
    const slab = this.parts.slab.value;
    const angle = this.angle.value;
    const grid = gridOf(path.length, this.height.value, this.parts.spacing(), slab);
    return { id: ++this.id, points: this.points.value, angle, slab, ...grid };
  }
}

/** Returns the nearest pixel. */
export const heldSpot = (grid: Grid, { column, row }: CurveSpot): CurveSpot => ({
  column: clamp(Math.round(column), 0, grid.columns - 1),
  row: clamp(Math.round(row), 0, grid.rows - 1),
});

/** Parses a remembered curve. Returns none if it is damaged. */
export function curveFrom(value: unknown): RememberedCurve {
  const curve = value as Partial<Record<keyof RememberedCurve, unknown>> | null | undefined;
  const points: unknown = curve?.points;
  if (!Array.isArray(points) || points.length > mostCurvePoints || !points.every(isPoint)) return noCurve;
  const number = (one: unknown, { low, high }: { low: number; high: number }, otherwise: number) =>
    isNumber(one) ? clamp(one, low, high) : otherwise;
  return {
    points,
    angle: number(curve?.angle, angleLimits, noCurve.angle),
    height: number(curve?.height, heightLimits, noCurve.height),
  };
}
