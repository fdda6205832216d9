import { create } from "@bufbuild/protobuf";
import { length } from "../input/vec3";
import { cameraOf } from "../protocol/messages";
import { TextureSchema, type Light, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { heightAtTarget } from "./lens";
import { middleOf } from "./light_geometry";
import { clamp, degrees, replaced } from "./numbers";

/** Generated patterns: screens in front of a lamp, and surroundings for the environment. */
export const lampTextures = ["soft", "ring", "window", "blinds"] as const;
export const skyTextures = ["horizon", "studio", "evening"] as const;
export type TextureName = (typeof lampTextures)[number] | (typeof skyTextures)[number];

/**
 * Patterns that a lamp can show on its surface. The others are visible only where a lamp projects
 * them.
 */
const surfaceTextures = ["soft", "ring"] as const;
const isOnSurface = (name: TextureName | undefined): boolean =>
  (surfaceTextures as readonly (TextureName | undefined)[]).includes(name);

export const isSky = (light: Light): boolean => light.shape.case === "environment";
const canProject = (light: Light): boolean => light.shape.case === "rectangle" || light.shape.case === "disk";
export const textureNames = (light: Light): readonly TextureName[] =>
  isSky(light) ? skyTextures : canProject(light) ? lampTextures : surfaceTextures;

/** The files of the built-in patterns. */
export type TextureFiles = ReadonlyMap<TextureName, Uint8Array<ArrayBuffer>>;

/** Returns the built-in pattern that a file contains. */
export const patternOf = (files: TextureFiles, file: Uint8Array): TextureName | undefined =>
  [...files].find(([, bytes]) => bytes.length === file.length && bytes.every((byte, i) => byte === file[i]))?.[0];

/** Limit for all images together. Every change sends the whole scene, in a message of at most 64 KB. */
export const mostTextureBytes = 36_000;
/** The longer side of the user's own image, which needs no fine detail because it only gives light. */
export const ownTextureSide = 128;

export const textureOf = (light: Light): Uint8Array | null => {
  const bytes = light.shape.value?.texture?.picture;
  return bytes && bytes.length > 0 ? bytes : null;
};

/** Whether an image of this size fits besides those of the other lights. */
export const textureFits = (scene: Scene, index: number, bytes: number): boolean =>
  scene.lights.reduce((sum, light, i) => sum + (i === index ? 0 : (textureOf(light)?.length ?? 0)), bytes) <=
  mostTextureBytes;

/**
 * Fraction of the picture's height that a projected pattern covers, so that no part of the patient
 * is beside it.
 */
const coveredPart = 0.8;

/**
 * Returns the angle over which a lamp projects a pattern onto what the picture shows, in degrees. 0
 * leaves the pattern on the surface of the lamp. From there, it only dims the light, because every
 * point of the patient sees all of it. `name` is undefined for the user's own image.
 */
export function projectionFor(scene: Scene, light: Light, name: TextureName | undefined): number {
  const pose = cameraOf(scene);
  const middle = middleOf(light);
  if (!pose || !middle || !canProject(light) || isOnSurface(name)) return 0;
  const parallel = scene.camera?.orthographicHeight ?? 0;
  const height = parallel > 0 ? parallel : heightAtTarget(pose);
  return clamp(2 * degrees(Math.atan((coveredPart * height) / 2 / Math.max(length(middle), 1))), 1, 170);
}

/**
 * Sets or removes the PNG or JPEG image of a light, projected or on its surface. Ignores an image that does not fit.
 */
export function setTexture(
  scene: Scene,
  index: number,
  picture: Uint8Array<ArrayBuffer> | null,
  projectionDegrees = 0,
): Scene {
  const light = scene.lights[index];
  if (!light?.shape.value || (picture && !textureFits(scene, index, picture.length))) return scene;
  const value: Record<string, unknown> = { ...light.shape.value };
  if (picture && light.shape.case === "environment") value.stored = "";
  if (picture) value.texture = create(TextureSchema, { picture, projectionDegrees });
  else Reflect.deleteProperty(value, "texture"); // the types distinguish an absent field from an undefined one
  return {
    ...scene,
    lights: replaced(scene.lights, index, {
      ...light,
      shape: { case: light.shape.case, value } as unknown as Light["shape"],
    }),
  };
}

export const hasTextures = (scene: Scene): boolean => scene.lights.some((light) => textureOf(light) !== null);

export const withoutTextures = (scene: Scene): Scene =>
  scene.lights.reduce((bare, light, i) => (textureOf(light) ? setTexture(bare, i, null) : bare), scene);

export interface Pixels {
  readonly width: number;
  readonly height: number;
  /** Opaque sRGB pixels, rows from the top. */
  readonly rgba: Uint8ClampedArray<ArrayBuffer>;
}

/**
 * Draws a built-in pattern. A texture of the environment is twice as wide as high (docs/scenes.md).
 */
export function texturePixels(name: TextureName): Pixels {
  const height = 48,
    width = (skyTextures as readonly string[]).includes(name) ? 2 * height : height;
  const rgba = new Uint8ClampedArray(4 * width * height);
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      rgba.set(
        [...colours[name]((x + 0.5) / width, (y + 0.5) / height).map((c) => 255 * clamp(c, 0, 1)), 255],
        4 * (x + width * y),
      );
    }
  }
  return { width, height, rgba };
}

type Colour = readonly [number, number, number];
const grey = (value: number): Colour => [value, value, value];
/** Returns a value that falls from 1 at `edge` to 0 at `edge` + `soft`. */
const until = (value: number, edge: number, soft: number): number => clamp(1 - (value - edge) / soft, 0, 1);
const mixed = (a: Colour, b: Colour, part: number): Colour => [
  a[0] + (b[0] - a[0]) * part,
  a[1] + (b[1] - a[1]) * part,
  a[2] + (b[2] - a[2]) * part,
];
const fromMiddle = (u: number, v: number): number => 2 * Math.hypot(u - 0.5, v - 0.5);
/** Returns the brightness at (u, v) of a bright area of the sky around (atU, atV). */
const field = (u: number, v: number, atU: number, atV: number): number =>
  until(Math.max(Math.abs(u - atU) * 2, Math.abs(v - atV)), 0.12, 0.06);

const colours: Readonly<Record<TextureName, (u: number, v: number) => Colour>> = {
  soft: (u, v) => grey(until(fromMiddle(u, v), 0.2, 0.8)),
  ring: (u, v) => grey(until(Math.abs(fromMiddle(u, v) - 0.75), 0.12, 0.1)),
  window: (u, v) => grey(Math.min(...[u, v].map((c) => until(0.07 - Math.min(c, 1 - c, Math.abs(c - 0.5)), 0, 0.03)))),
  blinds: (_, v) => grey(until(Math.abs(((6 * v) % 1) - 0.5), 0.25, 0.06)),
  horizon: (_, v) => mixed([0.16, 0.15, 0.14], [0.92, 0.96, 1], until(v, 0.46, 0.08)),
  studio: (u, v) =>
    grey(0.12 + 0.88 * Math.max(field(u, v, 0.3, 0.4), field(u, v, 0.72, 0.45) * 0.7, until(v, 0.05, 0.1))),
  evening: (u, v) =>
    mixed(
      mixed([0.12, 0.1, 0.12], [0.25, 0.3, 0.55], until(v, 0.5, 0.04)),
      [1, 0.62, 0.3],
      until(Math.hypot(2 * (u - 0.32), 1.4 * (v - 0.46)), 0.08, 0.4),
    ),
};

/** Returns the largest size of the same shape whose sides are at most `most`. */
export function fitted(
  width: number,
  height: number,
  most: number,
): { readonly width: number; readonly height: number } {
  const shrink = Math.min(1, most / Math.max(width, height, 1));
  return { width: Math.max(1, Math.round(width * shrink)), height: Math.max(1, Math.round(height * shrink)) };
}
