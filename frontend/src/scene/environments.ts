import {
  EnvironmentLightSchema,
  type EnvironmentLight,
  type Light,
  type Scene,
} from "../protocol/gen/api/proto/scene_pb";
import { create } from "@bufbuild/protobuf";
import { replaced, within, type Limits } from "./numbers";
import type { Pixels } from "./textures";

/** Environments that users have stored on the server. A scene refers to them by ID. */
export const rotationLimits: Limits = { low: -180, high: 180 };

const environmentOf = (light: Light | undefined): EnvironmentLight | null =>
  light?.shape.case === "environment" ? light.shape.value : null;

/** Returns the ID of the light's stored environment, or an empty string. */
export const storedOf = (light: Light): string => environmentOf(light)?.stored ?? "";

/** Returns the IDs of all stored environments of a scene, without duplicates. */
export const storedIn = (scene: Scene): readonly string[] => [
  ...new Set(scene.lights.flatMap((light) => storedOf(light) || [])),
];

export const rotationOf = (light: Light): number => environmentOf(light)?.rotationDegrees ?? 0;

const withEnvironment = (scene: Scene, index: number, edit: (light: EnvironmentLight) => EnvironmentLight): Scene => {
  const light = scene.lights[index];
  const environment = environmentOf(light);
  if (!light || !environment) return scene;
  return {
    ...scene,
    lights: replaced(scene.lights, index, { ...light, shape: { case: "environment", value: edit(environment) } }),
  };
};

/**
 * Lights the scene by a stored environment instead of a texture, or with an empty ID by neither.
 * The brightness stays.
 */
export const setStored = (scene: Scene, index: number, id: string): Scene =>
  withEnvironment(scene, index, ({ radiance, rotationDegrees }) =>
    create(EnvironmentLightSchema, { ...(radiance ? { radiance } : {}), rotationDegrees, stored: id }),
  );

/** Turns an environment to the right by an angle in degrees. */
export const turnEnvironment = (scene: Scene, index: number, degrees: number): Scene =>
  withEnvironment(scene, index, (light) => ({
    ...light,
    rotationDegrees: within(degrees, rotationLimits, light.rotationDegrees),
  }));

/** Decodes the preview of an environment: 32 x 16 pixels in hexadecimal. */
export function previewPixels(hexadecimal: string): Pixels {
  const width = 32,
    height = 16;
  const rgba = new Uint8ClampedArray(4 * width * height).fill(255);
  for (let i = 0; i < width * height; ++i) {
    for (let c = 0; c < 3; ++c) {
      const at = 6 * i + 2 * c;
      rgba[4 * i + c] = parseInt(hexadecimal.slice(at, at + 2), 16);
    }
  }
  return { width, height, rgba };
}
