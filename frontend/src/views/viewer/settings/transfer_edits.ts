import type { Channel, Scene } from "../../../protocol/gen/api/proto/scene_pb";
import type { Limits } from "../../../scene/numbers";
import * as transfer from "../../../scene/transfer";
import { sceneEdits, type Editor } from "./scene_edits";

/** A channel of the transfer function and one of its control points. */
export interface Selection {
  readonly channel: number;
  readonly point: number;
}

export interface PointPlace {
  readonly value: number;
  readonly opacity: number;
}

/** Limits the selection to the channels and points that exist. */
export function clampedSelection(channels: readonly Channel[], requested: Selection): Selection {
  const channel = Math.min(requested.channel, channels.length - 1);
  const points = channels[channel]?.opacity.length ?? 1;
  return { channel, point: Math.min(requested.point, points - 1) };
}

export interface TransferEdits {
  readonly rest: () => void;
  readonly choosePoint: (point: number) => void;
  readonly movePoint: (which: number, value: number, opacity: number, held: boolean) => void;
  /** Adds a point at `at`, or by default where there is most room. */
  readonly addPoint: (at?: PointPlace) => void;
  readonly removePoint: () => void;
  /** `range` is the range of the volume's values. */
  readonly addChannel: (name: string, range: Limits) => void;
  readonly showChannel: (index: number, shown: boolean) => void;
  readonly setMaterial: (what: string, material: transfer.Material, held: boolean) => void;
}

/**
 * Returns the edits of a scene's transfer function at the selection. `select` stores the new
 * selection.
 */
export function transferEdits(
  editor: Editor,
  scene: Scene,
  selected: Selection,
  select: (selection: Selection) => void,
): TransferEdits {
  const { rest, apply } = sceneEdits(editor);
  const { channel: index, point } = selected;
  const channels = transfer.channelsOf(scene);
  const channel = channels[index];
  const choosePoint = (next: number) => select({ channel: index, point: next });
  return {
    rest,
    choosePoint,
    movePoint: (which, value, opacity, held) =>
      editor.change(
        `point ${index} ${which}`,
        (now) => transfer.movePoint(now, index, which, { value, opacity }),
        held,
      ),
    addPoint: (at) => {
      const value = at?.value ?? (channel ? Math.round(transfer.roomiestValue(channel)) : 0);
      const added = channel && transfer.addPoint(scene, index, value, at?.opacity);
      if (!added) return;
      editor.change("point added", () => added.scene);
      choosePoint(added.index);
      rest();
    },
    removePoint: () => {
      editor.change("point removed", (now) => transfer.removePoint(now, index, point));
      choosePoint(Math.max(0, point - 1));
      rest();
    },
    addChannel: (name, range) => {
      editor.change("channel added", (now) => transfer.addChannel(now, name, range));
      select({ channel: channels.length, point: 1 });
      rest();
    },
    showChannel: (which, shown) =>
      apply(`shown ${which}`, (now) => transfer.setMaterial(now, which, { disabled: !shown })),
    setMaterial: (what, material, held) =>
      editor.change(`${what} ${index}`, (now) => transfer.setMaterial(now, index, material), held),
  };
}
