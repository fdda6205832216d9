import { add, cross, dot, length, normalize, scale, subtract, vec3, type Vec3 } from "../input/vec3";
import { Vec3Schema, type Light } from "../protocol/gen/api/proto/scene_pb";
import { create } from "@bufbuild/protobuf";
import { across } from "./direction";

/** Positions and directions of a light in its own frame: the camera's if it is locked to the camera, else the world. */

export const vector = (v: { readonly x: number; readonly y: number; readonly z: number } | undefined): Vec3 =>
  v ? vec3(v.x, v.y, v.z) : vec3(0, 0, 0);
export const message = (v: Vec3) => create(Vec3Schema, v);

/** Returns the centre of a light. Null for the environment, which has no position. */
export function middleOf(light: Light): Vec3 | null {
  const { shape } = light;
  switch (shape.case) {
    case "rectangle":
      return add(vector(shape.value.corner), scale(add(vector(shape.value.u), vector(shape.value.v)), 0.5));
    case "disk":
    case "sphere":
      return vector(shape.value.centre);
    case "box":
      return add(
        vector(shape.value.corner),
        scale(add(add(vector(shape.value.u), vector(shape.value.v)), vector(shape.value.w)), 0.5),
      );
    case "environment":
    case undefined:
      return null;
  }
}

/** Returns the direction in which a one-sided light shines. Null for the others. */
function normalOf({ shape }: Light): Vec3 | null {
  if (shape.case === "rectangle") return cross(vector(shape.value.u), vector(shape.value.v));
  return shape.case === "disk" ? vector(shape.value.normal) : null;
}

/**
 * The point that a light shines at, in mm from the middle of the picture or scan, as the light sees it. It lies in the
 * plane through the middle that faces the light. So it keeps its value when the light moves around the middle.
 */
export interface Target {
  readonly right: number;
  readonly up: number;
}

const atMiddle: Target = { right: 0, up: 0 };
const upright = (light: Light): Vec3 => (light.cameraLocked ? vec3(0, 1, 0) : vec3(0, 0, 1));

/** Returns the target of a light that shines along `normal`. A light that faces away from the middle has none. */
export function targetAlong(light: Light, normal: Vec3): Target | null {
  const middle = middleOf(light);
  if (!middle || length(middle) < 1e-9) return null;
  const facing = normalize(scale(middle, -1), vec3(0, 0, -1));
  const along = dot(normal, facing);
  if (along <= 1e-3 * length(normal)) return null;
  const target = add(middle, scale(normal, length(middle) / along));
  const [left, up] = across(facing, upright(light));
  const rounded = (mm: number) => Math.round(mm * 1e6) / 1e6 + 0; // + 0 turns -0 into 0
  return { right: rounded(-dot(target, left)), up: rounded(dot(target, up)) };
}

/** Returns the target of a light. Null for a light that shines in all directions. */
export function targetOf(light: Light): Target | null {
  const normal = normalOf(light);
  return normal && (targetAlong(light, normal) ?? atMiddle);
}

/** Moves a light and turns it to its target. */
export function placed(light: Light, towards: Vec3, distance: number, target = targetOf(light) ?? atMiddle): Light {
  const { shape } = light;
  const middle = scale(towards, distance);
  const [left, up] = across(scale(towards, -1), upright(light));
  const aim = add(scale(left, -target.right), scale(up, target.up));
  const facing = normalize(subtract(aim, middle), scale(towards, -1));
  switch (shape.case) {
    case "rectangle": {
      const [a, b] = across(facing, upright(light));
      const u = scale(a, length(vector(shape.value.u))),
        v = scale(b, length(vector(shape.value.v)));
      const corner = subtract(middle, scale(add(u, v), 0.5));
      return {
        ...light,
        shape: { case: "rectangle", value: { ...shape.value, corner: message(corner), u: message(u), v: message(v) } },
      };
    }
    case "disk":
      return {
        ...light,
        shape: { case: "disk", value: { ...shape.value, centre: message(middle), normal: message(facing) } },
      };
    case "sphere":
      return { ...light, shape: { case: "sphere", value: { ...shape.value, centre: message(middle) } } };
    case "box": {
      const old = middleOf(light) ?? middle;
      const corner = add(vector(shape.value.corner), subtract(middle, old));
      return { ...light, shape: { case: "box", value: { ...shape.value, corner: message(corner) } } };
    }
    case "environment":
    case undefined:
      return light;
  }
}

/**
 * Returns the surface area of a box with these edges, which is proportional to the light that it
 * emits in all directions.
 */
export function surfaceOf(u: Vec3, v: Vec3, w: Vec3): number {
  return 2 * (length(cross(u, v)) + length(cross(v, w)) + length(cross(w, u)));
}
