import { encode } from "jpeg-js";
import type { Scene } from "../../src/protocol/gen/api/proto/scene_pb";

type V = [number, number, number];
const dot = (a: V, b: V) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const sub = (a: V, b: V): V => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const norm = (a: V): V => {
  const n = Math.hypot(...a) || 1;
  return [a[0] / n, a[1] / n, a[2] / n];
};
const cross = (a: V, b: V): V => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const of = (v: { x: number; y: number; z: number } | undefined): V => [v?.x ?? 0, v?.y ?? 0, v?.z ?? 0];

/** A made-up head: ellipsoids with a nose towards -y. Noise falls with the square root of the samples. */
const parts: { at: V; size: V; tint: number }[] = [
  { at: [0, 0, 15], size: [72, 90, 85], tint: 1 },
  { at: [0, -40, -50], size: [48, 46, 50], tint: 0.95 },
  { at: [0, -92, -15], size: [11, 18, 16], tint: 0.9 },
  { at: [26, -78, 8], size: [15, 10, 11], tint: 0.35 },
  { at: [-26, -78, 8], size: [15, 10, 11], tint: 0.35 },
  { at: [73, 5, -10], size: [8, 16, 22], tint: 0.9 },
  { at: [-73, 5, -10], size: [8, 16, 22], tint: 0.9 },
];

/** `beat` is the part of a heartbeat, from 0 to 1: the head grows and shrinks as a heart does. */
export function draw(scene: Scene, width: number, height: number, samples: number, beat = 0): Buffer {
  const w = Math.max(16, Math.round(width / 4));
  const h = Math.max(16, Math.round(height / 4));
  const eye = of(scene.camera?.eye);
  const forward = norm(sub(of(scene.camera?.target), eye));
  const right = norm(cross(forward, of(scene.camera?.up)));
  const up = cross(right, forward);
  const half = Math.tan(((scene.camera?.verticalFovDegrees ?? 30) * Math.PI) / 360);
  const colour = scene.transferFunction?.channels[0]?.diffuse ?? { r: 0.8, g: 0.8, b: 0.8 };
  const data = Buffer.alloc(w * h * 4, 255);
  const noise = 0.5 / Math.sqrt(samples);
  const growth = 1 - 0.15 * Math.sin(Math.PI * beat) ** 2;
  const shapes = parts.map((part) => ({ ...part, size: part.size.map((edge) => edge * growth) as V }));
  for (let y = 0; y < h; y++)
    for (let x = 0; x < w; x++) {
      const a = ((2 * (x + 0.5)) / w - 1) * half * (w / h);
      const b = (1 - (2 * (y + 0.5)) / h) * half;
      const way = norm([
        forward[0] + a * right[0] + b * up[0],
        forward[1] + a * right[1] + b * up[1],
        forward[2] + a * right[2] + b * up[2],
      ]);
      const light = shade(shapes, eye, way, up, right);
      const grain = light > 0 ? (Math.random() - 0.5) * noise : 0;
      const at = 4 * (y * w + x);
      data[at] = level((light + grain) * colour.r, 12);
      data[at + 1] = level((light + grain) * colour.g, 16);
      data[at + 2] = level((light + grain) * colour.b, 20);
    }
  return encode({ data, width: w, height: h }, 82).data;
}

const level = (value: number, floor: number) => Math.min(255, floor + 255 * Math.pow(Math.max(0, value), 1 / 2.2));

function shade(shapes: typeof parts, eye: V, way: V, up: V, right: V): number {
  let nearest = Infinity;
  let light = 0;
  for (const { at, size, tint } of shapes) {
    const o = sub(eye, at).map((c, i) => c / (size[i] ?? 1)) as V;
    const d = way.map((c, i) => c / (size[i] ?? 1)) as V;
    const A = dot(d, d);
    const B = dot(o, d);
    const D = B * B - A * (dot(o, o) - 1);
    if (D <= 0) continue;
    const t = (-B - Math.sqrt(D)) / A;
    if (t <= 0 || t >= nearest) continue;
    nearest = t;
    const p = o.map((c, i) => c + t * (d[i] ?? 0)) as V;
    const normal = norm(p.map((c, i) => c / (size[i] ?? 1)) as V);
    const key = norm([up[0] - right[0] - way[0], up[1] - right[1] - way[1], up[2] - right[2] - way[2]]);
    light = tint * (0.08 + 0.75 * Math.max(0, dot(normal, key)) ** 1.3);
  }
  return light;
}
