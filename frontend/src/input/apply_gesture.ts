import { orbit_of, panned, pose_of, rolled, rotated, zoomed, type CameraPose } from "./camera";
import type { Gesture } from "./gestures";

/** The camera after a gesture. */
export function apply_gesture(pose: CameraPose, gesture: Gesture): CameraPose {
  const orbit = orbit_of(pose);
  switch (gesture.kind) {
    case "rotate":
      return pose_of(rotated(orbit, gesture.right, gesture.down));
    case "pan":
      return pose_of(panned(orbit, gesture.right, gesture.down));
    case "zoom":
      return pose_of(zoomed(orbit, gesture.factor));
    case "roll":
      return pose_of(rolled(orbit, gesture.angle));
  }
}
