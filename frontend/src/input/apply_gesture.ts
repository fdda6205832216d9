import { orbitOf, panned, poseOf, rolled, rotated, zoomed, type CameraPose } from "./camera";
import type { Gesture } from "./gestures";

/** Returns the camera after a gesture. */
export function applyGesture(pose: CameraPose, gesture: Gesture): CameraPose {
  const orbit = orbitOf(pose);
  switch (gesture.kind) {
    case "rotate":
      return poseOf(rotated(orbit, gesture.right, gesture.down));
    case "pan":
      return poseOf(panned(orbit, gesture.right, gesture.down));
    case "zoom":
      return poseOf(zoomed(orbit, gesture.factor));
    case "roll":
      return poseOf(rolled(orbit, gesture.angle));
  }
}
