import { add, cross, dot, length, normalize, scale, subtract, vec3, type Vec3 } from "../input/vec3";
import { clamp } from "../scene/numbers";

/** Limits of the server (volume/curve.h). */
export const mostCurvePoints = 64;
const samePoint = 1e-3;
/** Chords per segment. */
const steps = 64;

/** A point of the curve, its unit tangent, and a unit vector across the curve. */
export interface CurveFrame {
  readonly place: Vec3;
  readonly along: Vec3;
  readonly across: Vec3;
}

interface Node extends CurveFrame {
  /** The segment of the spline, and the position within it. */
  readonly parameter: number;
  /** The arc length from the start in mm. */
  readonly arc: number;
}

/** A segment of the spline in Hermite form. */
interface Segment {
  readonly from: Vec3;
  readonly to: Vec3;
  readonly leaving: Vec3;
  readonly arriving: Vec3;
}

const origin = vec3(0, 0, 0);
const nowhere: Segment = { from: origin, to: origin, leaving: origin, arriving: origin };

const mixed = (...parts: readonly (readonly [number, Vec3])[]): Vec3 =>
  parts.reduce((sum, [factor, vector]) => add(sum, scale(vector, factor)), origin);
const unit = (vector: Vec3): Vec3 => normalize(vector, vec3(1, 0, 0));
const perpendicular = (vector: Vec3, along: Vec3): Vec3 => unit(subtract(vector, scale(along, dot(vector, along))));
const reflected = (vector: Vec3, normal: Vec3): Vec3 =>
  subtract(vector, scale(normal, (2 * dot(normal, vector)) / dot(normal, normal)));

/**
 * The smooth curve through points that the server straightens slices along, with the same frames (volume/curve.h): a
 * centripetal Catmull-Rom spline with rotation-minimising frames, measured by arc length.
 */
export class Curve {
  private constructor(
    private readonly segments: readonly Segment[],
    private readonly nodes: readonly Node[],
  ) {}

  /** Returns null if fewer than two points differ. */
  static through(points: readonly Vec3[]): Curve | null {
    const kept: Vec3[] = [];
    for (const point of points) {
      const last = kept.at(-1);
      if (!last || length(subtract(point, last)) >= samePoint) kept.push(point);
    }
    if (kept.length < 2) return null;
    const segments = segmentsOf(kept);
    return new Curve(segments, framed(segments, nodesOf(segments)));
  }

  /** The length in mm. */
  get length(): number {
    return this.nodes.at(-1)?.arc ?? 0;
  }

  /** Points along the curve that are close enough together to draw it. */
  get places(): readonly Vec3[] {
    return this.nodes.filter((_, i) => i % 4 === 0).map(({ place }) => place);
  }

  /** Returns the frame at an arc length, limited to the curve. */
  at(arc: number): CurveFrame {
    const held = clamp(arc, 0, this.length);
    const [low, high] = this.around(held);
    const part = (held - low.arc) / (high.arc - low.arc);
    const place = placeAt(this.segments, low.parameter + part * (high.parameter - low.parameter));
    // Where the curve turns back on itself, the tangents at both ends are opposite.
    if (dot(low.along, high.along) < 0) return { ...low, place };
    const along = unit(mixed([1 - part, low.along], [part, high.along]));
    return { place, along, across: perpendicular(mixed([1 - part, low.across], [part, high.across]), along) };
  }

  /** Returns the arc length of the point of the curve that is nearest to a place, and the distance in mm. */
  nearest(place: Vec3): { readonly arc: number; readonly away: number } {
    let best = { arc: 0, away: Infinity };
    this.nodes.forEach((node, i) => {
      const next = this.nodes[i + 1];
      if (!next) return;
      const chord = subtract(next.place, node.place);
      const part = clamp(dot(subtract(place, node.place), chord) / dot(chord, chord), 0, 1);
      const away = length(subtract(place, mixed([1, node.place], [part, chord])));
      if (away < best.away) best = { arc: node.arc + part * (next.arc - node.arc), away };
    });
    return best;
  }

  private around(arc: number): readonly [Node, Node] {
    let [low, high] = [0, this.nodes.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if ((this.nodes[middle]?.arc ?? 0) <= arc) low = middle;
      else high = middle;
    }
    return [this.nodes[low], this.nodes[high]] as [Node, Node];
  }
}

/** Mirrored points before the first and after the last one let the curve end straight. */
function segmentsOf(points: readonly Vec3[]): readonly Segment[] {
  const [first, second] = points as [Vec3, Vec3];
  const [before, last] = points.slice(-2) as [Vec3, Vec3];
  const knots = [mixed([2, first], [-1, second]), ...points, mixed([2, last], [-1, before])];
  const chords = knots.slice(1).map((knot, i) => subtract(knot, knots[i] ?? knot));
  const intervals = chords.map((chord) => Math.sqrt(length(chord)));
  // The derivative at the point after chord k - 1, per unit of the parameter.
  const derivative = (k: number): Vec3 => {
    const [one, two] = [intervals[k - 1] ?? 1, intervals[k] ?? 1];
    const [a, b] = [chords[k - 1] ?? first, chords[k] ?? first];
    return mixed([1 / one, a], [1 / two, b], [-1 / (one + two), add(a, b)]);
  };
  return points.slice(1).map((to, i) => {
    const interval = intervals[i + 1] ?? 1;
    const [leaving, arriving] = [derivative(i + 1), derivative(i + 2)].map((one) => scale(one, interval));
    return { from: points[i] ?? to, to, leaving: leaving ?? first, arriving: arriving ?? first };
  });
}

function within(segments: readonly Segment[], parameter: number): readonly [Segment, number] {
  const i = Math.min(Math.floor(parameter), segments.length - 1);
  return [segments[i] ?? nowhere, parameter - i];
}

function placeAt(segments: readonly Segment[], parameter: number): Vec3 {
  const [{ from, to, leaving, arriving }, u] = within(segments, parameter);
  const v = 1 - u;
  return mixed([v * v * (1 + 2 * u), from], [u * u * (3 - 2 * u), to], [u * v * v, leaving], [-u * u * v, arriving]);
}

function derivativeAt(segments: readonly Segment[], parameter: number): Vec3 {
  const [{ from, to, leaving, arriving }, u] = within(segments, parameter);
  const v = 1 - u;
  return mixed([6 * u * v, subtract(to, from)], [v * (1 - 3 * u), leaving], [u * (3 * u - 2), arriving]);
}

type Measured = Omit<Node, "along" | "across">;

function nodesOf(segments: readonly Segment[]): readonly Measured[] {
  const nodes: Measured[] = [];
  for (let k = 0; k <= steps * segments.length; ++k) {
    const place = placeAt(segments, k / steps);
    const before = nodes.at(-1);
    nodes.push({
      parameter: k / steps,
      place,
      arc: before ? before.arc + length(subtract(place, before.place)) : 0,
    });
  }
  return nodes;
}

function framed(segments: readonly Segment[], nodes: readonly Measured[]): readonly Node[] {
  const tangents = nodes.map(({ parameter }, k) => {
    const derivative = derivativeAt(segments, parameter);
    // Where the curve turns back on itself, the derivative vanishes, and the next chord decides.
    const next = Math.min(k + 1, nodes.length - 1);
    const chord = subtract(nodes[next]?.place ?? derivative, nodes[next - 1]?.place ?? derivative);
    return unit(length(derivative) > 1e-6 * length(chord) ? derivative : chord);
  });
  let before: Node | null = null;
  return nodes.map((node, k) => {
    const along = tangents[k] ?? vec3(1, 0, 0);
    const across = before ? carriedAcross(before, node.place, along) : firstAcross(nodes, along);
    before = { ...node, along, across };
    return before;
  });
}

/** Moves the vector across the curve to the next node without twist, by two reflections (Wang et al. 2008). */
function carriedAcross(before: CurveFrame, place: Vec3, along: Vec3): Vec3 {
  const chord = subtract(place, before.place);
  const across = reflected(before.across, chord);
  const second = subtract(along, reflected(before.along, chord));
  // Where the curve turns back on itself, the first reflection is enough.
  return perpendicular(dot(second, second) > 1e-12 ? reflected(across, second) : across, along);
}

const directions = [vec3(0, 0, -1), vec3(1, 0, 0), vec3(0, 1, 0)] as const;
const mostParallel = 0.95;

/** Returns the patient axis that is least parallel to the curve, made perpendicular to its first tangent. */
function firstAcross(nodes: readonly Measured[], along: Vec3): Vec3 {
  const margin = 1e-9 * (nodes.at(-1)?.arc ?? 0);
  let best: { readonly direction: Vec3; readonly parallel: number } | null = null;
  for (const direction of directions) {
    if (Math.abs(dot(along, direction)) > mostParallel) continue;
    const parallel = nodes.slice(1).reduce((sum, node, i) => {
      const before = nodes[i] ?? node;
      return sum + dot(subtract(node.place, before.place), direction) ** 2 / (node.arc - before.arc);
    }, 0);
    if (!best || parallel < best.parallel - margin) best = { direction, parallel };
  }
  return perpendicular(best?.direction ?? directions[0], along);
}

/** Returns the direction of the rows of a slice that is turned by an angle in degrees about the curve. */
export function turnedAcross({ along, across }: CurveFrame, degrees: number): Vec3 {
  const angle = (Math.PI / 180) * degrees;
  return mixed([Math.cos(angle), across], [Math.sin(angle), cross(along, across)]);
}
