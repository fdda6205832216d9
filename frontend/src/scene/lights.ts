import { create } from "@bufbuild/protobuf";
import type { CameraPose } from "../input/camera";
import { add, length, normalize, scale, subtract, vec3, type Vec3 } from "../input/vec3";
import {
  BoxLightSchema,
  DiskLightSchema,
  EnvironmentLightSchema,
  LightSchema,
  RectangleLightSchema,
  SphereLightSchema,
  type Light,
  type Rgb,
  type Scene,
} from "../protocol/gen/api/proto/scene_pb";
import { rgb, scaled, strengthOf, withHue } from "./colour";
import { directionOf, fromWorld, ofPatient, seenFromFront, toWorld, unitOf, type Direction } from "./direction";
import { message, middleOf, placed, surfaceOf, targetAlong, targetOf, vector, type Target } from "./light_geometry";
import { replaced, within, without, type Limits } from "./numbers";

/** Limits within those of scene/check_lights.cpp. */
export const mostLights = 64;
export const distanceLimits: Limits = { low: 10, high: 5000 };
export const sizeLimits: Limits = { low: 1, high: 3000 };
export const intensityLimits: Limits = { low: 0.01, high: 100 };
export const turnLimits: Limits = { low: -180, high: 180 };
export const tiltLimits: Limits = { low: -90, high: 90 };
export const targetLimits: Limits = { low: -1000, high: 1000 };
export const aspectLimits: Limits = { low: 0.05, high: 20 };
const brightest = 1e12;

export type { Target };
export { targetOf };
export type Shape = Exclude<Light["shape"]["case"], undefined>;

const withLight = (scene: Scene, index: number, edit: (light: Light) => Light): Scene => {
  const light = scene.lights[index];
  if (!light) return scene;
  const edited = edit(light);
  return edited === light ? scene : { ...scene, lights: replaced(scene.lights, index, edited) };
};

export interface Place extends Direction {
  /** Distance from the middle in mm. */
  readonly distance: number;
}

/**
 * Returns the position of a light: as seen in the picture if it is locked to the camera, else as seen from in front of
 * the patient.
 */
export function placeOf(light: Light): Place | null {
  const middle = middleOf(light);
  if (!middle) return null;
  const seen = light.cameraLocked ? middle : seenFromFront(middle);
  return { ...directionOf(seen), distance: length(middle) };
}

/**
 * Returns the direction of a light as seen in the picture. The front is towards the viewer. Null
 * for the environment.
 */
export function seenDirection(light: Light, pose: CameraPose): Direction | null {
  const middle = middleOf(light);
  return middle && directionOf(light.cameraLocked ? middle : fromWorld(pose, middle, true));
}

/** Moves a light to a direction in the picture and keeps its distance. */
export function aimLight(scene: Scene, index: number, pose: CameraPose, seen: Direction): Scene {
  const light = scene.lights[index];
  if (!light || !placeOf(light)) return scene;
  if (light.cameraLocked) return placeLight(scene, index, { right: seen.right, up: seen.up });
  return placeLight(scene, index, directionOf(seenFromFront(toWorld(pose, unitOf(seen), true))));
}

/** Moves a light, which keeps its target. */
export function placeLight(scene: Scene, index: number, to: Partial<Place>): Scene {
  return withLight(scene, index, (light) => {
    const old = placeOf(light);
    if (!old) return light;
    const right = within(to.right ?? old.right, turnLimits, old.right);
    const up = within(to.up ?? old.up, tiltLimits, old.up);
    const distance = within(to.distance ?? old.distance, distanceLimits, old.distance);
    const seen = unitOf({ right, up });
    return placed(light, light.cameraLocked ? seen : ofPatient(seen), distance);
  });
}

/** Turns a light to another target. */
export const turnLight = (scene: Scene, index: number, to: Partial<Target>): Scene =>
  withLight(scene, index, (light) => {
    const middle = middleOf(light);
    const old = targetOf(light);
    if (!middle || !old) return light;
    const target = {
      right: within(to.right ?? old.right, targetLimits, old.right),
      up: within(to.up ?? old.up, targetLimits, old.up),
    };
    return placed(light, normalize(middle, vec3(0, 0, 1)), length(middle), target);
  });

/**
 * Turns a light to a point of the world. Returns null if the point is not in front of the light.
 */
export function turnLightTo(scene: Scene, index: number, pose: CameraPose, point: Vec3): Scene | null {
  const light = scene.lights[index];
  const middle = light && middleOf(light);
  if (!light || !middle) return null;
  const target = targetAlong(light, subtract(light.cameraLocked ? fromWorld(pose, point) : point, middle));
  return target && turnLight(scene, index, target);
}

/**
 * Returns the width of a rectangle or box relative to its height, and for a box also its depth.
 * Null for round lights.
 */
export function aspectOf({ shape }: Light): { readonly width: number; readonly depth: number | null } | null {
  if (shape.case !== "rectangle" && shape.case !== "box") return null;
  const height = length(vector(shape.value.v));
  return {
    width: length(vector(shape.value.u)) / height,
    depth: shape.case === "box" ? length(vector(shape.value.w)) / height : null,
  };
}

/**
 * Changes the proportions of a light and keeps its brightness on the patient. A rectangle also
 * keeps its area.
 */
export const shapeLight = (scene: Scene, index: number, to: { readonly width?: number; readonly depth?: number }) =>
  withLight(scene, index, (light) => {
    const { shape } = light;
    const old = aspectOf(light);
    const middle = middleOf(light);
    if (!old || !middle || (shape.case !== "rectangle" && shape.case !== "box")) return light;
    const wider = Math.sqrt(within(to.width ?? old.width, aspectLimits, old.width) / old.width);
    const u = scale(vector(shape.value.u), wider),
      v = scale(vector(shape.value.v), 1 / wider);
    const half = add(u, v);
    if (shape.case === "rectangle") {
      const corner = message(subtract(middle, scale(half, 0.5)));
      return { ...light, shape: { ...shape, value: { ...shape.value, corner, u: message(u), v: message(v) } } };
    }
    const depth = within(to.depth ?? old.depth ?? 1, aspectLimits, old.depth ?? 1);
    const before = vector(shape.value.w);
    const w = scale(before, (depth * length(v)) / length(before));
    const value = {
      ...shape.value,
      corner: message(subtract(middle, scale(add(half, w), 0.5))),
      u: message(u),
      v: message(v),
      w: message(w),
      radiance: dimmed(
        shape.value.radiance,
        surfaceOf(vector(shape.value.u), vector(shape.value.v), before) / surfaceOf(u, v, w),
      ),
    };
    return { ...light, shape: { ...shape, value } };
  });

/** Returns the longest edge or the diameter in mm. Null for the environment. */
export function sizeOf(light: Light): number | null {
  const { shape } = light;
  switch (shape.case) {
    case "rectangle":
      return Math.max(length(vector(shape.value.u)), length(vector(shape.value.v)));
    case "disk":
    case "sphere":
      return 2 * shape.value.radius;
    case "box":
      return Math.max(...[shape.value.u, shape.value.v, shape.value.w].map((edge) => length(vector(edge))));
    case "environment":
    case undefined:
      return null;
  }
}

/**
 * Changes the size of a light and keeps its brightness on the patient. A larger light makes softer shadows, not more
 * light.
 */
export function sizeLight(scene: Scene, index: number, size: number): Scene {
  return withLight(scene, index, (light) => {
    const old = sizeOf(light);
    const { shape } = light;
    if (old === null) return light;
    const to = within(size, sizeLimits, old);
    if (to === old) return light;
    const grown = to / old;
    if (shape.case === "disk" || shape.case === "sphere") {
      // The radiance of a point light is multiplied by its area.
      const share = old > 0 ? 1 / (grown * grown) : 1 / (Math.PI * (to / 2) ** 2);
      const value = { ...shape.value, radius: to / 2, radiance: dimmed(shape.value.radiance, share) };
      return { ...light, shape: { case: shape.case, value } as Light["shape"] };
    }
    if (shape.case !== "rectangle" && shape.case !== "box") return light;
    const middle = middleOf(light) ?? vec3(0, 0, 0);
    const value = {
      ...shape.value,
      corner: message(add(middle, scale(subtract(vector(shape.value.corner), middle), grown))),
      u: message(scale(vector(shape.value.u), grown)),
      v: message(scale(vector(shape.value.v), grown)),
      ...(shape.case === "box" ? { w: message(scale(vector(shape.value.w), grown)) } : {}),
      radiance: dimmed(shape.value.radiance, 1 / (grown * grown)),
    };
    return { ...light, shape: { case: shape.case, value } as Light["shape"] };
  });
}

function dimmed(colour: Rgb | undefined, by: number): Rgb {
  const to = scaled(colour ?? rgb(0, 0, 0), by);
  const strength = strengthOf(to);
  return strength > brightest ? scaled(to, brightest / strength) : to;
}

export const radianceOf = (light: Light): Rgb | undefined => light.shape.value?.radiance;

export const colourLight = (scene: Scene, index: number, hue: Rgb): Scene =>
  withLight(scene, index, (light) => {
    if (!light.shape.value) return light;
    const value = { ...light.shape.value, radiance: withHue(light.shape.value.radiance, hue) };
    return { ...light, shape: { case: light.shape.case, value } as Light["shape"] };
  });

/** Returns the intensity of a light. 0 in a scene means 1. */
export const intensityOf = (light: Light): number => (light.intensity === 0 ? 1 : light.intensity);

export const dimLight = (scene: Scene, index: number, intensity: number): Scene =>
  withLight(scene, index, (light) => ({
    ...light,
    intensity: within(intensity, intensityLimits, intensityOf(light)),
  }));

export const switchLight = (scene: Scene, index: number, disabled: boolean): Scene =>
  withLight(scene, index, (light) => ({ ...light, disabled }));
export const nameLight = (scene: Scene, index: number, name: string): Scene =>
  withLight(scene, index, (light) => ({ ...light, name: name.slice(0, 60) }));

/** Locks a light to the camera, or unlocks it, without moving it. */
export function lockLight(scene: Scene, index: number, locked: boolean, pose: CameraPose): Scene {
  return withLight(scene, index, (light) => {
    if (light.cameraLocked === locked) return light;
    const at = (v: Parameters<typeof vector>[0]) => message((locked ? fromWorld : toWorld)(pose, vector(v)));
    const way = (v: Parameters<typeof vector>[0]) => message((locked ? fromWorld : toWorld)(pose, vector(v), true));
    const { shape } = light;
    const to = (value: object): Light => ({
      ...light,
      cameraLocked: locked,
      shape: { case: shape.case, value } as Light["shape"],
    });
    switch (shape.case) {
      case "rectangle":
        return to({ ...shape.value, corner: at(shape.value.corner), u: way(shape.value.u), v: way(shape.value.v) });
      case "disk":
        return to({ ...shape.value, centre: at(shape.value.centre), normal: way(shape.value.normal) });
      case "sphere":
        return to({ ...shape.value, centre: at(shape.value.centre) });
      case "box":
        return to({
          ...shape.value,
          corner: at(shape.value.corner),
          u: way(shape.value.u),
          v: way(shape.value.v),
          w: way(shape.value.w),
        });
      case "environment":
      case undefined:
        return { ...light, cameraLocked: locked };
    }
  });
}

/** Irradiance at the middle of a new light with intensity 1, so that all shapes start equally bright. */
const irradiance = 8;

/** Area of a new light of size 1, projected towards the middle. */
const areaSeen: Readonly<Record<Shape, (towards: Vec3) => number>> = {
  rectangle: () => 1,
  disk: () => Math.PI / 4,
  sphere: () => Math.PI / 4,
  environment: () => 1,
  box: ({ x, y, z }) => Math.abs(x) + Math.abs(y) + Math.abs(z),
};

/** Numbers the name if a light of the scene already has it. */
function unusedName(scene: Scene, name: string): string {
  const taken = new Set(scene.lights.map((light) => light.name));
  let number = 1;
  while (taken.has(number === 1 ? name : `${name} ${number}`)) number += 1;
  return number === 1 ? name : `${name} ${number}`;
}

/**
 * Adds a light that is locked to the camera, above on the left, at a distance that suits a volume of this radius in mm.
 */
export function addLight(scene: Scene, shape: Shape, name: string, radius: number): Scene {
  if (scene.lights.length >= mostLights) return scene;
  const distance = within(3 * radius, distanceLimits, 500);
  const edge = within(radius, sizeLimits, 100);
  const towards = normalize(vec3(-0.8, 0.6, 0.8), vec3(0, 0, 1));
  const area = edge * edge * areaSeen[shape](towards);
  const strength = (irradiance * distance * distance) / area;
  const radiance = shape === "environment" ? rgb(0.3, 0.3, 0.3) : rgb(strength, strength, strength);
  const light = create(LightSchema, {
    name: unusedName(scene, name),
    cameraLocked: shape !== "environment",
    intensity: 1,
    shape: firstShape(shape, edge, radiance),
  });
  return { ...scene, lights: [...scene.lights, placed(light, towards, distance)] };
}

function firstShape(shape: Shape, edge: number, radiance: Rgb): Light["shape"] {
  switch (shape) {
    case "rectangle":
      return {
        case: shape,
        value: create(RectangleLightSchema, {
          corner: { x: 0, y: 0, z: 0 },
          u: { x: edge, y: 0, z: 0 },
          v: { x: 0, y: edge, z: 0 },
          radiance,
        }),
      };
    case "disk":
      return {
        case: shape,
        value: create(DiskLightSchema, {
          centre: { x: 0, y: 0, z: 1 },
          normal: { x: 0, y: 0, z: -1 },
          radius: edge / 2,
          radiance,
        }),
      };
    case "sphere":
      return {
        case: shape,
        value: create(SphereLightSchema, { centre: { x: 0, y: 0, z: 1 }, radius: edge / 2, radiance }),
      };
    case "box":
      return {
        case: shape,
        value: create(BoxLightSchema, {
          corner: { x: 0, y: 0, z: 0 },
          u: { x: edge, y: 0, z: 0 },
          v: { x: 0, y: edge, z: 0 },
          w: { x: 0, y: 0, z: edge },
          radiance,
        }),
      };
    case "environment":
      return { case: shape, value: create(EnvironmentLightSchema, { radiance }) };
  }
}

export const removeLight = (scene: Scene, index: number): Scene => ({
  ...scene,
  lights: without(scene.lights, index),
});
