import { create, type MessageInitShape } from "@bufbuild/protobuf";
import { cross, length, vec3, type Vec3 } from "../input/vec3";
import {
  ChannelSchema,
  LightSchema,
  SceneSchema,
  Slices_Colouring as SlicesColouring,
  type Light,
  type Rgb,
  type Scene,
} from "../protocol/gen/api/proto/scene_pb";
import { middleOf, vector } from "./light_geometry";

const someChannels: MessageInitShape<typeof ChannelSchema>[] = [
  {
    name: "muscle",
    diffuse: { r: 0.8, g: 0.3, b: 0.2 },
    opacity: [
      { value: 5, opacity: 0 },
      { value: 55, opacity: 0.75 },
      { value: 260, opacity: 0 },
    ],
  },
  {
    name: "bone",
    diffuse: { r: 0.95, g: 0.9, b: 0.75 },
    opacity: [
      { value: 180, opacity: 0 },
      { value: 420, opacity: 1 },
      { value: 3072, opacity: 1 },
    ],
  },
];

const someLights: MessageInitShape<typeof LightSchema>[] = [
  {
    name: "key",
    cameraLocked: true,
    shape: {
      case: "rectangle",
      value: {
        corner: { x: -300, y: 200, z: 300 },
        u: { x: 100, y: 0, z: 0 },
        v: { x: 0, y: 100, z: 0 },
        radiance: { r: 40, g: 38, b: 36 },
      },
    },
  },
  {
    name: "disk",
    shape: {
      case: "disk",
      value: {
        centre: { x: 0, y: -400, z: 0 },
        normal: { x: 0, y: 1, z: 0 },
        radius: 50,
        radiance: { r: 10, g: 10, b: 10 },
      },
    },
  },
  {
    name: "bulb",
    shape: {
      case: "sphere",
      value: { centre: { x: 100, y: -400, z: 50 }, radius: 0, radiance: { r: 5000, g: 5000, b: 5000 } },
    },
  },
  {
    name: "box",
    shape: {
      case: "box",
      value: {
        corner: { x: 200, y: 0, z: 0 },
        u: { x: 10, y: 0, z: 0 },
        v: { x: 0, y: 20, z: 0 },
        w: { x: 0, y: 0, z: 30 },
        radiance: { r: 1, g: 2, b: 3 },
      },
    },
  },
  { name: "sky", shape: { case: "environment", value: { radiance: { r: 0.26, g: 0.27, b: 0.29 } } } },
];

/** A scene like the renderer's own, for tests. */
export const someScene = (): Scene =>
  create(SceneSchema, {
    transferFunction: { extinctionPerMm: 1.1, channels: someChannels },
    lights: someLights,
    camera: {
      eye: { x: 0, y: -500, z: 60 },
      target: { x: 0, y: 0, z: 0 },
      up: { x: 0, y: 0, z: 1 },
      verticalFovDegrees: 30,
    },
    display: { background: { r: 0.01, g: 0.012, b: 0.015 } },
    phase: { g: 0 },
  });

export const someBounds = { low: vec3(-120, -130, -80), high: vec3(120, 130, 80) };

type Vector = Partial<Vec3> | undefined;
const numbers = (v: Vector): number[] => [v?.x ?? 0, v?.y ?? 0, v?.z ?? 0];
const long = (v: Vector) => Math.hypot(...numbers(v));
const crossed = (a: Vector, b: Vector): Vec3 => {
  const [ax = 0, ay = 0, az = 0] = numbers(a),
    [bx = 0, by = 0, bz = 0] = numbers(b);
  return vec3(ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx);
};

/** Collects the errors of a scene. */
class Findings {
  readonly found: string[] = [];

  must(holds: boolean, what: string): void {
    if (!holds) this.found.push(what);
  }
  range(value: number, low: number, high: number, what: string): void {
    this.must(value >= low && value <= high, `${what}: ${value}`);
  }
  place(v: Vector, what: string): void {
    for (const n of numbers(v)) this.range(n, -1e7, 1e7, what);
  }
  colour(c: Rgb | undefined, most: number, what: string): void {
    for (const n of [c?.r ?? 0, c?.g ?? 0, c?.b ?? 0]) this.range(n, 0, most, what);
  }
}

/** Returns the errors that the server (scene/check_scene.cpp, check_lights.cpp) would find in a scene. */
export function refused(scene: Scene): string[] {
  const findings = new Findings();
  checkTransfer(scene, findings);
  findings.must(scene.lights.length <= 4096, "lights");
  for (const light of scene.lights) checkLight(light, findings);
  checkCamera(scene, findings);
  checkDisplay(scene, findings);
  checkClip(scene, findings);
  checkSlices(scene, findings);
  return findings.found;
}

function checkTransfer({ transferFunction }: Scene, check: Findings): void {
  const channels = transferFunction?.channels ?? [];
  check.range(channels.length, 1, 64, "channels");
  check.range(transferFunction?.extinctionPerMm ?? 0, 0, 1e7, "extinction");
  for (const { opacity, diffuse, specular, gloss, emission } of channels) {
    check.range(opacity.length, 2, 1024, "points");
    opacity.forEach((p, i) => {
      check.range(p.value, -1e9, 1e9, "value");
      check.range(p.opacity, 0, 1, "opacity");
      check.must(i === 0 || p.value > (opacity[i - 1]?.value ?? 0), `point ${i} is not above the one before`);
    });
    check.colour(diffuse, 1, "diffuse");
    check.colour(specular, 1, "specular");
    check.range(gloss, 0, 1, "gloss");
    check.colour(emission, 1e15, "emission");
  }
}

function checkCamera({ camera }: Scene, check: Findings): void {
  check.must(camera !== undefined, "camera");
  for (const v of [camera?.eye, camera?.target, camera?.up]) check.place(v, "camera");
  const [ex = 0, ey = 0, ez = 0] = numbers(camera?.eye),
    [tx = 0, ty = 0, tz = 0] = numbers(camera?.target);
  const back = vec3(ex - tx, ey - ty, ez - tz);
  check.must(long(back) >= 1e-6, "eye at the target");
  check.must(long(crossed(camera?.up, back)) > 1e-9 * long(camera?.up) * long(back), "up along the view");
  const height = camera?.orthographicHeight ?? 0;
  check.range(height, 0, 1e7, "orthographic height");
  check.range(camera?.verticalFovDegrees ?? 0, height > 0 ? 0 : 1e-3, 179.9, "field of view");
  check.range(camera?.apertureRadius ?? 0, 0, 1e7, "aperture");
  const focus = camera?.focalDistance ?? 0;
  check.must(focus === 0 || (focus >= 1e-6 && focus <= 1e7), "focus");
}

function checkDisplay(scene: Scene, check: Findings): void {
  check.must(Math.abs(scene.phase?.g ?? 0) < 1, "phase");
  check.range(scene.display?.exposure ?? 0, -64, 64, "exposure");
  check.must([0, 1].includes(scene.display?.curve ?? 0), "curve");
  check.colour(scene.display?.background, 1e15, "background");
  check.colour(scene.display?.backgroundEdge, 1e15, "backgroundEdge");
  const gradient = scene.shading?.gradientScale ?? 0;
  check.must(gradient === 0 || (gradient >= 1e-9 && gradient <= 1e9), "gradient");
  check.must(Number.isInteger(scene.bounces) && scene.bounces >= 0 && scene.bounces <= 1024, "bounces");
}

function checkClip({ clip }: Scene, check: Findings): void {
  check.must((clip?.boxLow === undefined) === (clip?.boxHigh === undefined), "half a box");
  const low = numbers(clip?.boxLow),
    high = numbers(clip?.boxHigh);
  low.forEach((n, i) => check.must(n <= (high[i] ?? 0), "a box inside out"));
  check.range(clip?.planes.length ?? 0, 0, 6, "planes");
  for (const plane of clip?.planes ?? []) {
    check.place(plane.point, "plane");
    check.must(long(plane.normal) >= 1e-6, "normal");
  }
}

function checkSlices({ slices }: Scene, check: Findings): void {
  const all = [slices?.sagittal, slices?.coronal, slices?.axial];
  for (const slice of all) check.range(slice?.position ?? 0, -1e7, 1e7, "slice");
  const grey = all.some((slice) => slice?.shown) && slices?.colouring === SlicesColouring.GREY;
  check.range(slices?.windowWidth ?? 0, grey ? 1e-6 : 0, 1e9, "window");
  check.range(slices?.windowCentre ?? 0, -1e9, 1e9, "window");
}

function checkLight(light: Light, check: Findings): void {
  const { shape } = light;
  check.must(shape.case !== undefined, "a light without a shape");
  const strength = Math.max(0, ...Object.values(shape.value?.radiance ?? {}).filter((n) => typeof n === "number"));
  check.must(
    strength <= 1e15 && light.intensity >= 0 && light.intensity * strength <= 1e15,
    `strength of a light: ${strength}`,
  );
  if (shape.case === "rectangle" || shape.case === "box") {
    check.place(shape.value.corner, "corner");
    const { u, v } = shape.value;
    check.must(long(u) >= 1e-6 && long(v) >= 1e-6, "an edge too short");
    check.must(long(crossed(u, v)) > 1e-6 * long(u) * long(v), "parallel edges");
  } else if (shape.case === "disk" || shape.case === "sphere") {
    check.place(shape.value.centre, "centre");
    const radius = shape.value.radius;
    check.must(radius === 0 || (radius >= 1e-6 && radius <= 1e7), `radius ${radius}`);
    if (shape.case === "disk") check.must(long(shape.value.normal) >= 1e-6, "normal");
  }
}

/** Whether a rectangle shines towards the middle. */
export function facesMiddle(light: Light): boolean {
  const middle = middleOf(light);
  if (light.shape.case !== "rectangle" || !middle) return false;
  const normal = cross(vector(light.shape.value.u), vector(light.shape.value.v));
  return (
    length(cross(normal, middle)) < 1e-6 * length(normal) * length(middle) &&
    normal.x * middle.x + normal.y * middle.y + normal.z * middle.z < 0
  );
}
