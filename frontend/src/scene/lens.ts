import { create } from "@bufbuild/protobuf";
import { closestMm, farthestMm, type CameraPose } from "../input/camera";
import { add, length, scale, subtract } from "../input/vec3";
import { camera_of, with_camera } from "../protocol/messages";
import { DisplaySchema, PhaseSchema, Shading_Mode, ShadingSchema, type Display, type Rgb, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { clamp, radians, within, type Limits } from "./numbers";

export const fov_limits: Limits = { low: 1, high: 120 };
export const aperture_limits: Limits = { low: 0, high: 100 };
export const focus_limits: Limits = { low: 1, high: farthestMm };
export const exposure_limits: Limits = { low: -10, high: 10 };
export const bounces_limits: Limits = { low: 1, high: 1024 };
export const forward_limits: Limits = { low: -0.99, high: 0.99 };
export const gradient_limits: Limits = { low: 0.001, high: 10 };

/** mm that the picture is high at the target. */
export const height_at_target = (pose: CameraPose): number => 2 * length(subtract(pose.eye, pose.target)) * Math.tan(radians(pose.verticalFovDegrees) / 2);

/** Wider or narrower; the eye goes nearer or away, so that the middle stays as large as it is. */
export function set_fov(scene: Scene, degrees: number): Scene {
  const pose = camera_of(scene);
  if (!pose) return scene;
  const verticalFovDegrees = within(degrees, fov_limits, pose.verticalFovDegrees);
  const away = subtract(pose.eye, pose.target);
  const distance = length(away);
  const to = clamp(height_at_target(pose) / (2 * Math.tan(radians(verticalFovDegrees) / 2)), closestMm, farthestMm);
  return with_camera(scene, { ...pose, verticalFovDegrees, eye: add(pose.target, scale(away, to / distance)) });
}

export const is_orthographic = (scene: Scene): boolean => (scene.camera?.orthographicHeight ?? 0) > 0;

/** The middle stays as large as it is. */
export function set_orthographic(scene: Scene, on: boolean): Scene {
  const pose = camera_of(scene);
  if (!pose || !scene.camera) return scene;
  // A camera that came with parallel rays may have no angle.
  const verticalFovDegrees = within(pose.verticalFovDegrees, fov_limits, 30);
  const orthographicHeight = on ? height_at_target({ ...pose, verticalFovDegrees }) : 0;
  return { ...scene, camera: { ...scene.camera, verticalFovDegrees, orthographicHeight } };
}

/** Radius in mm; 0: all is sharp. */
export const set_aperture = (scene: Scene, radius: number): Scene =>
  scene.camera ? { ...scene, camera: { ...scene.camera, apertureRadius: within(radius, aperture_limits, scene.camera.apertureRadius) } } : scene;

/** mm from the eye; nothing: the middle, wherever one goes. */
export const set_focus = (scene: Scene, distance: number | null): Scene =>
  scene.camera
    ? { ...scene, camera: { ...scene.camera, focalDistance: distance === null ? 0 : within(distance, focus_limits, scene.camera.focalDistance) } }
    : scene;

/** A lens of which one sees that it is sharp somewhere: a fiftieth of the distance. */
const seen_aperture = (distance: number): number => clamp(distance / 50, 1, 20);

/** Sharp at so many mm; a pinhole, with which all is sharp, is opened. */
export function focus_at(scene: Scene, distance: number): Scene {
  const focused = set_focus(scene, distance);
  return focused.camera?.apertureRadius === 0 ? set_aperture(focused, seen_aperture(distance)) : focused;
}

export function focus_of(scene: Scene): { readonly distance: number; readonly middle: boolean } {
  const pose = camera_of(scene);
  const own = scene.camera?.focalDistance ?? 0;
  return own > 0 ? { distance: own, middle: false } : { distance: pose ? length(subtract(pose.eye, pose.target)) : 0, middle: true };
}

const display_of = (scene: Scene): Display => scene.display ?? create(DisplaySchema);

/** In stops: each is twice as bright. */
export const set_exposure = (scene: Scene, stops: number): Scene => {
  const old = display_of(scene);
  return { ...scene, display: { ...old, exposure: within(stops, exposure_limits, old.exposure) } };
};

export const set_background = (scene: Scene, colour: Rgb): Scene => ({ ...scene, display: { ...display_of(scene), background: colour, showEnvironment: false } });
export const show_environment = (scene: Scene, on: boolean): Scene => ({ ...scene, display: { ...display_of(scene), showEnvironment: on } });

/** 0 in a scene means 1. */
export const bounces_of = (scene: Scene): number => Math.max(1, scene.bounces);
export const set_bounces = (scene: Scene, bounces: number): Scene => ({ ...scene, bounces: Math.round(within(bounces, bounces_limits, bounces_of(scene))) });

export const mode_of = (scene: Scene): Shading_Mode => scene.shading?.mode ?? Shading_Mode.PHASE;
export const set_mode = (scene: Scene, mode: Shading_Mode): Scene => ({ ...scene, shading: { ...(scene.shading ?? create(ShadingSchema)), mode } });

export const gradient_of = (scene: Scene): number => (scene.shading && scene.shading.gradientScale > 0 ? scene.shading.gradientScale : 0.1);
export const set_gradient = (scene: Scene, gradient: number): Scene =>
  ({ ...scene, shading: { ...(scene.shading ?? create(ShadingSchema)), gradientScale: within(gradient, gradient_limits, gradient_of(scene)) } });

export const set_forward = (scene: Scene, g: number): Scene => {
  const old = scene.phase ?? create(PhaseSchema);
  return { ...scene, phase: { ...old, g: within(g, forward_limits, old.g) } };
};
