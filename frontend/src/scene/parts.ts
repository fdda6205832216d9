import type { Scene } from "../protocol/gen/api/proto/scene_pb";

/** What is reset on its own. Where one looks from has its own way (the view's reset). */
export type Part = "look" | "light" | "lens" | "cuts";

/** `scene` with that part as it was in `begun`. */
export function resetPart(scene: Scene, begun: Scene, part: Part): Scene {
  switch (part) {
    case "look":
      return taken(scene, begun, ["transferFunction"]);
    case "light":
      return taken(scene, begun, ["lights"]);
    case "lens":
      return withLensOf(taken(scene, begun, ["display", "phase", "shading", "bounces"]), begun);
    case "cuts":
      return taken(scene, begun, ["clip", "slices", "showTable"]);
  }
}

function taken(scene: Scene, begun: Scene, fields: readonly (keyof Scene)[]): Scene {
  const to: Record<string, unknown> = { ...scene };
  for (const field of fields) {
    if (begun[field] === undefined)
      Reflect.deleteProperty(to, field); // absent and undefined are two things to the types
    else to[field] = begun[field];
  }
  return to as unknown as Scene;
}

/** The eye stays where it is; only how it sees is taken. */
function withLensOf(scene: Scene, begun: Scene): Scene {
  if (!scene.camera || !begun.camera) return scene;
  const { verticalFovDegrees, orthographicHeight, apertureRadius, focalDistance } = begun.camera;
  return {
    ...scene,
    camera: { ...scene.camera, verticalFovDegrees, orthographicHeight, apertureRadius, focalDistance },
  };
}
