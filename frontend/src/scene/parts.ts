import type { Scene } from "../protocol/gen/api/proto/scene_pb";

/** The parts that can be reset separately. The viewpoint has its own reset. */
export type Part = "look" | "light" | "lens" | "cuts" | "labels";

/** Returns `scene` with this part as in `begun`. */
export function resetPart(scene: Scene, begun: Scene, part: Part): Scene {
  switch (part) {
    case "look":
      return taken(scene, begun, ["transferFunction"]);
    case "light":
      return taken(scene, begun, ["lights"]);
    case "lens":
      return withLensOf(taken(scene, begun, ["display", "phase", "shading", "bounces"]), begun);
    case "labels":
      return taken(scene, begun, ["labels"]);
    case "cuts":
      return taken(scene, begun, ["clip", "slices", "showTable"]);
  }
}

function taken(scene: Scene, begun: Scene, fields: readonly (keyof Scene)[]): Scene {
  const to: Record<string, unknown> = { ...scene };
  for (const field of fields) {
    if (begun[field] === undefined)
      Reflect.deleteProperty(to, field); // the types distinguish an absent field from an undefined one
    else to[field] = begun[field];
  }
  return to as unknown as Scene;
}

/** Returns `scene` with the lens of `begun`, but not its eye position. */
function withLensOf(scene: Scene, begun: Scene): Scene {
  if (!scene.camera || !begun.camera) return scene;
  const { verticalFovDegrees, orthographicHeight, apertureRadius, focalDistance } = begun.camera;
  return {
    ...scene,
    camera: { ...scene.camera, verticalFovDegrees, orthographicHeight, apertureRadius, focalDistance },
  };
}
