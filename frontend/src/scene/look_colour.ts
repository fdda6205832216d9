import type { Channel, Scene } from "../protocol/gen/api/proto/scene_pb";
import { hexOf } from "./colour";
import { channelsOf } from "./transfer";

const strongestOpacity = (channel: Channel): number => Math.max(0, ...channel.opacity.map(({ opacity }) => opacity));

/**
 * Returns the colour that represents a look without a picture: that of its first clearly visible
 * material.
 */
export function lookColour(scene: Scene | undefined): string | null {
  const shown = scene ? channelsOf(scene).filter(({ disabled }) => !disabled) : [];
  const most = Math.max(0, ...shown.map(strongestOpacity));
  const first = shown.find((channel) => most > 0 && strongestOpacity(channel) >= most / 2);
  return first ? hexOf(first.diffuse) : null;
}
