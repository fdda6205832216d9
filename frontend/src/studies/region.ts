import { create, equals } from "@bufbuild/protobuf";
import { HighlightSchema, Vec3Schema, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { rgb } from "../scene/colour";
import type { Region } from "./definition";

/** Blue does not occur naturally in a body (thesis 6.2.2). */
const highlightColour = rgb(0.05, 0.25, 0.9);
const highlightStrength = 0.75;

/** Returns the scene with a region highlighted, or with no highlight. Returns the same scene if nothing changes. */
export function withRegion(scene: Scene, region: Region | null): Scene {
  if (region === null) {
    if (!scene.highlight) return scene;
    const plain = { ...scene };
    delete plain.highlight;
    return plain;
  }
  const [x, y, z] = region.centre;
  const highlight = create(HighlightSchema, {
    centre: create(Vec3Schema, { x, y, z }),
    radius: region.radius,
    colour: highlightColour,
    strength: highlightStrength,
  });
  return scene.highlight && equals(HighlightSchema, scene.highlight, highlight) ? scene : { ...scene, highlight };
}
