import { create } from "@bufbuild/protobuf";
import { vec3, type Vec3 } from "../input/vec3";
import { SceneSchema, Slices_Colouring, type Light, type Rgb, type Scene } from "../protocol/gen/api/proto/scene_pb";

/** A scene like the renderer's own, for tests. */
export const some_scene = (): Scene =>
  create(SceneSchema, {
    transferFunction: {
      extinctionPerMm: 1.1,
      channels: [
        { name: "muscle", diffuse: { r: 0.8, g: 0.3, b: 0.2 }, opacity: [{ value: 5, opacity: 0 }, { value: 55, opacity: 0.75 }, { value: 260, opacity: 0 }] },
        { name: "bone", diffuse: { r: 0.95, g: 0.9, b: 0.75 }, opacity: [{ value: 180, opacity: 0 }, { value: 420, opacity: 1 }, { value: 3072, opacity: 1 }] },
      ],
    },
    lights: [
      { name: "key", cameraLocked: true, shape: { case: "rectangle", value: { corner: { x: -300, y: 200, z: 300 }, u: { x: 100, y: 0, z: 0 }, v: { x: 0, y: 100, z: 0 }, radiance: { r: 40, g: 38, b: 36 } } } },
      { name: "disk", shape: { case: "disk", value: { centre: { x: 0, y: -400, z: 0 }, normal: { x: 0, y: 1, z: 0 }, radius: 50, radiance: { r: 10, g: 10, b: 10 } } } },
      { name: "bulb", shape: { case: "sphere", value: { centre: { x: 100, y: -400, z: 50 }, radius: 0, radiance: { r: 5000, g: 5000, b: 5000 } } } },
      { name: "box", shape: { case: "box", value: { corner: { x: 200, y: 0, z: 0 }, u: { x: 10, y: 0, z: 0 }, v: { x: 0, y: 20, z: 0 }, w: { x: 0, y: 0, z: 30 }, radiance: { r: 1, g: 2, b: 3 } } } },
      { name: "sky", shape: { case: "environment", value: { radiance: { r: 0.26, g: 0.27, b: 0.29 } } } },
    ],
    camera: { eye: { x: 0, y: -500, z: 60 }, target: { x: 0, y: 0, z: 0 }, up: { x: 0, y: 0, z: 1 }, verticalFovDegrees: 30 },
    display: { background: { r: 0.01, g: 0.012, b: 0.015 } },
    phase: { g: 0 },
  });

export const some_bounds = { low: vec3(-120, -130, -80), high: vec3(120, 130, 80) };

type Vector = Partial<Vec3> | undefined;
const numbers = (v: Vector): number[] => [v?.x ?? 0, v?.y ?? 0, v?.z ?? 0];
const long = (v: Vector) => Math.hypot(...numbers(v));
const crossed = (a: Vector, b: Vector): Vec3 => {
  const [ax = 0, ay = 0, az = 0] = numbers(a), [bx = 0, by = 0, bz = 0] = numbers(b);
  return vec3(ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx);
};

/** What the server's check (scene/check_scene.cpp, check_lights.cpp) would say of it: nothing where it would take it. */
export function refused(scene: Scene): string[] {
  const found: string[] = [];
  const must = (holds: boolean, what: string) => {
    if (!holds) found.push(what);
  };
  const range = (value: number, low: number, high: number, what: string) => must(value >= low && value <= high, `${what}: ${value}`);
  const place = (v: Vector, what: string) => numbers(v).forEach((n) => range(n, -1e7, 1e7, what));
  const colour = (c: Rgb | undefined, most: number, what: string) => [c?.r ?? 0, c?.g ?? 0, c?.b ?? 0].forEach((n) => range(n, 0, most, what));

  const channels = scene.transferFunction?.channels ?? [];
  range(channels.length, 1, 64, "channels");
  range(scene.transferFunction?.extinctionPerMm ?? 0, 0, 1e7, "extinction");
  for (const { opacity, diffuse, specular, gloss, emission } of channels) {
    range(opacity.length, 2, 1024, "points");
    opacity.forEach((p, i) => {
      range(p.value, -1e9, 1e9, "value");
      range(p.opacity, 0, 1, "opacity");
      must(i === 0 || p.value > (opacity[i - 1]?.value ?? 0), `point ${i} is not above the one before`);
    });
    colour(diffuse, 1, "diffuse");
    colour(specular, 1, "specular");
    range(gloss, 0, 1, "gloss");
    colour(emission, 1e15, "emission");
  }

  must(scene.lights.length <= 4096, "lights");
  scene.lights.forEach((light) => check_light(light, must, place));

  const camera = scene.camera;
  must(camera !== undefined, "camera");
  for (const v of [camera?.eye, camera?.target, camera?.up]) place(v, "camera");
  const back = vec3(0, 0, 0);
  const [ex = 0, ey = 0, ez = 0] = numbers(camera?.eye), [tx = 0, ty = 0, tz = 0] = numbers(camera?.target);
  Object.assign(back, { x: ex - tx, y: ey - ty, z: ez - tz });
  must(long(back) >= 1e-6, "eye at the target");
  must(long(crossed(camera?.up, back)) > 1e-9 * long(camera?.up) * long(back), "up along the view");
  range(camera?.orthographicHeight ?? 0, 0, 1e7, "orthographic height");
  range(camera?.verticalFovDegrees ?? 0, (camera?.orthographicHeight ?? 0) > 0 ? 0 : 1e-3, 179.9, "field of view");
  range(camera?.apertureRadius ?? 0, 0, 1e7, "aperture");
  const focus = camera?.focalDistance ?? 0;
  must(focus === 0 || (focus >= 1e-6 && focus <= 1e7), "focus");
  must(Math.abs(scene.phase?.g ?? 0) < 1, "phase");
  range(scene.display?.exposure ?? 0, -64, 64, "exposure");
  colour(scene.display?.background, 1e15, "background");
  const gradient = scene.shading?.gradientScale ?? 0;
  must(gradient === 0 || (gradient >= 1e-9 && gradient <= 1e9), "gradient");
  must(Number.isInteger(scene.bounces) && scene.bounces >= 0 && scene.bounces <= 1024, "bounces");

  const clip = scene.clip;
  must((clip?.boxLow === undefined) === (clip?.boxHigh === undefined), "half a box");
  const low = numbers(clip?.boxLow), high = numbers(clip?.boxHigh);
  low.forEach((n, i) => must(n <= (high[i] ?? 0), "a box inside out"));
  range(clip?.planes.length ?? 0, 0, 6, "planes");
  for (const plane of clip?.planes ?? []) {
    place(plane.point, "plane");
    must(long(plane.normal) >= 1e-6, "normal");
  }
  const slices = scene.slices;
  const shown = [slices?.sagittal, slices?.coronal, slices?.axial].filter((slice) => slice?.shown);
  for (const slice of [slices?.sagittal, slices?.coronal, slices?.axial]) range(slice?.position ?? 0, -1e7, 1e7, "slice");
  const grey = shown.length > 0 && slices?.colouring === Slices_Colouring.GREY;
  range(slices?.windowWidth ?? 0, grey ? 1e-6 : 0, 1e9, "window");
  range(slices?.windowCentre ?? 0, -1e9, 1e9, "window");
  return found;
}

function check_light(light: Light, must: (holds: boolean, what: string) => void, place: (v: Vector, what: string) => void): void {
  const { shape } = light;
  must(shape.case !== undefined, "a light without a shape");
  const strength = Math.max(0, ...Object.values(shape.value?.radiance ?? {}).filter((n) => typeof n === "number"));
  must(strength <= 1e15 && light.intensity >= 0 && light.intensity * strength <= 1e15, `strength of a light: ${strength}`);
  if (shape.case === "rectangle" || shape.case === "box") {
    place(shape.value.corner, "corner");
    const { u, v } = shape.value;
    must(long(u) >= 1e-6 && long(v) >= 1e-6, "an edge too short");
    must(long(crossed(u, v)) > 1e-6 * long(u) * long(v), "parallel edges");
  } else if (shape.case === "disk" || shape.case === "sphere") {
    place(shape.value.centre, "centre");
    const radius = shape.value.radius;
    must(radius === 0 || (radius >= 1e-6 && radius <= 1e7), `radius ${radius}`);
    if (shape.case === "disk") must(long(shape.value.normal) >= 1e-6, "normal");
  }
}
