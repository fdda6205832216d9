import type { Area, Point } from "../input/flat";
import { add, length, normalize, scale, subtract, vec3, type Vec3 } from "../input/vec3";
import { cameraOf } from "../protocol/messages";
import type { Scene } from "../protocol/gen/api/proto/scene_pb";
import * as cuts from "../scene/cuts";
import { directionOnBall, unitOf } from "../scene/direction";
import * as lights from "../scene/lights";
import { clamp } from "../scene/numbers";
import { beside, dragged, faceOf, middleOf, onScreen, planeInBox, type Axis, type Box, type Eye } from "./project";

/** A handle in the picture. Like a slider, it has a position and limits. */
export interface Handle extends Point {
  readonly key: string;
  readonly of: HandleOf;
  readonly now: number;
  readonly low: number;
  readonly high: number;
  /** Where two handles overlap, the one with the lower rank is shown. */
  readonly rank: number;
  /** Whether the handle is on the side facing away from the viewer. */
  readonly behind?: boolean;
}

export type HandleOf =
  | { readonly kind: "face"; readonly axis: Axis; readonly side: cuts.Side }
  | { readonly kind: "plane" | "tilt"; readonly index: number }
  | { readonly kind: "light"; readonly index: number };

/** Returns the scene's camera. */
export function eyeOf(scene: Scene): Eye | null {
  const pose = cameraOf(scene);
  return pose && { ...pose, orthographicHeight: scene.camera?.orthographicHeight ?? 0 };
}

const keyOf = (of: HandleOf): string => (of.kind === "face" ? `${of.axis}-${of.side}` : `${of.kind}-${of.index}`);

/**
 * Returns one handle per face of the box, and two per plane: one moves it, and one at the tip of its normal tilts it.
 */
export function cutHandles(scene: Scene, bounds: Box, screen: Area): Handle[] {
  const eye = eyeOf(scene);
  if (!eye) return [];
  const box = cuts.boxOf(scene, bounds);
  const faces = cuts.axes.flatMap((axis) =>
    (["low", "high"] as const).flatMap((side) => {
      const { place } = faceOf(box, axis, side);
      const point = onScreen(eye, screen, place);
      const of = { kind: "face", axis, side } as const;
      const { low, high } = cuts.faceLimits(scene, bounds, axis, side);
      return point
        ? [{ key: keyOf(of), of, ...point, now: box[side][axis], low, high, rank: length(subtract(place, eye.eye)) }]
        : [];
    }),
  );
  const planes = cuts.planesOf(scene).flatMap((plane, index) => {
    const drawn = drawnPlane(scene, bounds, index);
    if (!drawn) return [];
    const reach = cuts.reachOf(bounds);
    const ofBase = { kind: "plane", index } as const,
      ofTip = { kind: "tilt", index } as const;
    const base = onScreen(eye, screen, drawn.base),
      tip = onScreen(eye, screen, drawn.tip);
    return [
      ...(base
        ? [{ key: keyOf(ofBase), of: ofBase, ...base, now: plane.offset, low: -reach, high: reach, rank: -1 }]
        : []),
      ...(tip ? [{ key: keyOf(ofTip), of: ofTip, ...tip, now: plane.up, low: -90, high: 90, rank: 0 }] : []),
    ];
  });
  return [...planes, ...faces];
}

/** A plane as it is drawn: its intersection with the box and its normal. */
export interface DrawnPlane {
  readonly polygon: readonly Vec3[];
  readonly base: Vec3;
  readonly tip: Vec3;
}

export function drawnPlane(scene: Scene, bounds: Box, index: number): DrawnPlane | null {
  const plane = cuts.planesOf(scene)[index];
  if (!plane) return null;
  const normal = cuts.normalOf(plane);
  const polygon = planeInBox(cuts.boxOf(scene, bounds), normal, plane.offset);
  // A plane outside the box also gets a position, or it could not be moved back.
  const base = middleOf(polygon) ?? scale(normal, plane.offset);
  return { polygon, base, tip: add(base, scale(normal, 0.45 * cuts.reachOf(bounds))) };
}

/** The radius of the ball on which lights are placed, as a fraction of half the picture's shorter side. */
const ballPart = 0.8;
export const ballRadius = (screen: Area): number => Math.max(1, (ballPart * Math.min(screen.width, screen.height)) / 2);

/** Returns a handle per light, on a ball around the middle of the picture. The environment has none. */
export function lightHandles(scene: Scene, screen: Area): Handle[] {
  const eye = eyeOf(scene);
  if (!eye) return [];
  const radius = ballRadius(screen);
  return scene.lights.flatMap((light, index) => {
    const direction = light.disabled ? null : lights.seenDirection(light, eye);
    if (!direction) return [];
    const n = unitOf(direction);
    const of = { kind: "light", index } as const;
    const point = { x: screen.width / 2 + n.x * radius, y: screen.height / 2 - n.y * radius };
    return [{ key: keyOf(of), of, ...point, now: direction.right, low: -180, high: 180, rank: index, behind: n.z < 0 }];
  });
}

/** Returns the scene after a handle was dragged to `to`. */
export function handleDragged(scene: Scene, bounds: Box, screen: Area, handle: Handle, to: Point): Scene {
  const eye = eyeOf(scene);
  if (!eye) return scene;
  const by = { x: to.x - handle.x, y: to.y - handle.y };
  const { of } = handle;
  switch (of.kind) {
    case "face": {
      const { place, along } = faceOf(cuts.boxOf(scene, bounds), of.axis, of.side);
      const mm = dragged(eye, screen, place, along, by);
      return mm === null ? scene : cuts.moveFace(scene, bounds, of.axis, of.side, handle.now + mm);
    }
    case "plane": {
      const drawn = drawnPlane(scene, bounds, of.index),
        plane = cuts.planesOf(scene)[of.index];
      const mm = drawn && plane && dragged(eye, screen, drawn.base, cuts.normalOf(plane), by);
      return typeof mm === "number" ? cuts.movePlane(scene, bounds, of.index, { offset: handle.now + mm }) : scene;
    }
    case "tilt": {
      const drawn = drawnPlane(scene, bounds, of.index);
      if (!drawn) return scene;
      const normal = normalize(subtract(beside(eye, screen, drawn.tip, by), drawn.base), vec3(0, -1, 0));
      return cuts.turnPlane(scene, bounds, of.index, normal, drawn.base);
    }
    case "light": {
      const radius = ballRadius(screen);
      const x = (to.x - screen.width / 2) / radius,
        y = (to.y - screen.height / 2) / radius;
      return lights.aimLight(scene, of.index, eye, directionOnBall(x, y, handle.behind ?? false).direction);
    }
  }
}

/**
 * Returns the scene after arrow keys moved a handle. `right` and `up` count key presses. A face and a plane move along
 * one direction only.
 */
export function handleStepped(scene: Scene, bounds: Box, handle: Handle, right: number, up: number): Scene {
  const { of } = handle;
  switch (of.kind) {
    case "face":
      return cuts.moveFace(scene, bounds, of.axis, of.side, handle.now + right + up);
    case "plane":
      return cuts.movePlane(scene, bounds, of.index, { offset: handle.now + right + up });
    case "tilt": {
      const plane = cuts.planesOf(scene)[of.index];
      return plane
        ? cuts.movePlane(scene, bounds, of.index, {
            right: turned(plane.right + right),
            up: clamp(plane.up + up, -90, 90),
          })
        : scene;
    }
    case "light": {
      const eye = eyeOf(scene),
        light = scene.lights[of.index];
      const direction = eye && light && lights.seenDirection(light, eye);
      return direction
        ? lights.aimLight(scene, of.index, eye, {
            right: turned(direction.right + 5 * right),
            up: clamp(direction.up + 5 * up, -90, 90),
          })
        : scene;
    }
  }
}

const turned = (angle: number): number => angle - 360 * Math.round(angle / 360);
