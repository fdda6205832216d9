import { create } from "@bufbuild/protobuf";
import { closestMm, farthestMm, type CameraPose } from "../input/camera";
import { add, length, scale, subtract } from "../input/vec3";
import { cameraOf, withCamera } from "../protocol/messages";
import {
  Display_Curve as DisplayCurve,
  DisplaySchema,
  PhaseSchema,
  Shading_Mode as ShadingMode,
  ShadingSchema,
  type Display,
  type Rgb,
  type Scene,
} from "../protocol/gen/api/proto/scene_pb";
import { clamp, radians, within, type Limits } from "./numbers";

export const fovLimits: Limits = { low: 1, high: 120 };
export const apertureLimits: Limits = { low: 0, high: 100 };
export const focusLimits: Limits = { low: 1, high: farthestMm };
export const exposureLimits: Limits = { low: -10, high: 10 };
export const bouncesLimits: Limits = { low: 1, high: 1024 };
export const forwardLimits: Limits = { low: -0.99, high: 0.99 };
export const gradientLimits: Limits = { low: 0.001, high: 10 };

/** Returns the height of the picture in mm at the target. */
export const heightAtTarget = (pose: CameraPose): number =>
  2 * length(subtract(pose.eye, pose.target)) * Math.tan(radians(pose.verticalFovDegrees) / 2);

/** Changes the field of view and moves the eye, so that the target keeps its size. */
export function setFov(scene: Scene, degrees: number): Scene {
  const pose = cameraOf(scene);
  if (!pose) return scene;
  const verticalFovDegrees = within(degrees, fovLimits, pose.verticalFovDegrees);
  const away = subtract(pose.eye, pose.target);
  const distance = length(away);
  const to = clamp(heightAtTarget(pose) / (2 * Math.tan(radians(verticalFovDegrees) / 2)), closestMm, farthestMm);
  return withCamera(scene, { ...pose, verticalFovDegrees, eye: add(pose.target, scale(away, to / distance)) });
}

export const isOrthographic = (scene: Scene): boolean => (scene.camera?.orthographicHeight ?? 0) > 0;

/** Changes the projection and keeps the size of the target. */
export function setOrthographic(scene: Scene, on: boolean): Scene {
  const pose = cameraOf(scene);
  if (!pose || !scene.camera) return scene;
  // An orthographic camera may have no field of view.
  const verticalFovDegrees = within(pose.verticalFovDegrees, fovLimits, 30);
  const orthographicHeight = on ? heightAtTarget({ ...pose, verticalFovDegrees }) : 0;
  return { ...scene, camera: { ...scene.camera, verticalFovDegrees, orthographicHeight } };
}

/** Sets the radius of the aperture in mm. With 0, everything is sharp. */
export const setAperture = (scene: Scene, radius: number): Scene =>
  scene.camera
    ? {
        ...scene,
        camera: { ...scene.camera, apertureRadius: within(radius, apertureLimits, scene.camera.apertureRadius) },
      }
    : scene;

/** Sets the focus in mm from the eye. With null, it stays on the target. */
export const setFocus = (scene: Scene, distance: number | null): Scene =>
  scene.camera
    ? {
        ...scene,
        camera: {
          ...scene.camera,
          focalDistance: distance === null ? 0 : within(distance, focusLimits, scene.camera.focalDistance),
        },
      }
    : scene;

/** Returns an aperture with a visible depth of field: a fiftieth of the distance. */
const seenAperture = (distance: number): number => clamp(distance / 50, 1, 20);

/** Focuses at a distance in mm. Opens the aperture if it is a pinhole, with which everything is sharp. */
export function focusAt(scene: Scene, distance: number): Scene {
  const focused = setFocus(scene, distance);
  return focused.camera?.apertureRadius === 0 ? setAperture(focused, seenAperture(distance)) : focused;
}

export function focusOf(scene: Scene): { readonly distance: number; readonly middle: boolean } {
  const pose = cameraOf(scene);
  const own = scene.camera?.focalDistance ?? 0;
  return own > 0
    ? { distance: own, middle: false }
    : { distance: pose ? length(subtract(pose.eye, pose.target)) : 0, middle: true };
}

const displayOf = (scene: Scene): Display => scene.display ?? create(DisplaySchema);

/** Sets the exposure in stops. Each stop doubles the brightness. */
export const setExposure = (scene: Scene, stops: number): Scene => {
  const old = displayOf(scene);
  return { ...scene, display: { ...old, exposure: within(stops, exposureLimits, old.exposure) } };
};

export const isExposureAutomatic = (scene: Scene): boolean => displayOf(scene).automaticExposure;
export const setExposureAutomatic = (scene: Scene, on: boolean): Scene => ({
  ...scene,
  display: { ...displayOf(scene), automaticExposure: on },
});

export const isFilmic = (scene: Scene): boolean => displayOf(scene).curve === DisplayCurve.FILMIC;
export const setFilmic = (scene: Scene, on: boolean): Scene => ({
  ...scene,
  display: { ...displayOf(scene), curve: on ? DisplayCurve.FILMIC : DisplayCurve.LINEAR },
});

export const setBackground = (scene: Scene, colour: Rgb): Scene => ({
  ...scene,
  display: { ...displayOf(scene), background: colour, backgroundEdge: undefined, showEnvironment: false },
});
export const showEnvironment = (scene: Scene, on: boolean): Scene => ({
  ...scene,
  display: { ...displayOf(scene), showEnvironment: on },
});

/** Returns the number of bounces. 0 in a scene means 1. */
export const bouncesOf = (scene: Scene): number => Math.max(1, scene.bounces);
export const setBounces = (scene: Scene, bounces: number): Scene => ({
  ...scene,
  bounces: Math.round(within(bounces, bouncesLimits, bouncesOf(scene))),
});

export const modeOf = (scene: Scene): ShadingMode => scene.shading?.mode ?? ShadingMode.PHASE;
export const setMode = (scene: Scene, mode: ShadingMode): Scene => ({
  ...scene,
  shading: { ...(scene.shading ?? create(ShadingSchema)), mode },
});

export const gradientOf = (scene: Scene): number =>
  scene.shading && scene.shading.gradientScale > 0 ? scene.shading.gradientScale : 0.1;
export const setGradient = (scene: Scene, gradient: number): Scene => ({
  ...scene,
  shading: {
    ...(scene.shading ?? create(ShadingSchema)),
    gradientScale: within(gradient, gradientLimits, gradientOf(scene)),
  },
});

/** The initial g of the Henyey-Greenstein phase function, whose effect is clearly visible. */
export const firstForward = 0.5;

export const setForward = (scene: Scene, g: number): Scene => {
  const old = scene.phase ?? create(PhaseSchema);
  return { ...scene, phase: { ...old, g: within(g, forwardLimits, old.g) } };
};
