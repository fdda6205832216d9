import { create, equals } from "@bufbuild/protobuf";
import {
  OverlaySchema,
  Overlay_Mode as OverlayMode,
  TransferFunctionSchema,
  type Overlay,
  type OverlayLook,
  type Scene,
} from "../protocol/gen/api/proto/scene_pb";

export { OverlayMode };

const clamp = (value: number): number => Math.min(1, Math.max(0, value));

const edited = (scene: Scene, change: Partial<Overlay>): Scene =>
  scene.overlay ? { ...scene, overlay: create(OverlaySchema, { ...scene.overlay, ...change }) } : scene;

/** Shows the second scan as a built-in look has it. What the user has set for the mixture stays. */
export function withOverlayLook(scene: Scene, { overlay }: OverlayLook): Scene {
  if (!overlay?.transferFunction) return scene;
  if (!scene.overlay) return { ...scene, overlay };
  return edited(scene, { transferFunction: overlay.transferFunction });
}

/** Sets how much of the second scan is mixed in, from 0 to 1. */
export const setShare = (scene: Scene, share: number): Scene => edited(scene, { share: clamp(share) });

/** Sets where the divider between the two scans is, from 0 at the left edge of the picture to 1. */
export const setSplit = (scene: Scene, split: number): Scene => edited(scene, { split: clamp(split) });

/** Shows both scans mixed, or one beside the other with a divider, which begins in the middle. */
export function setOverlayMode(scene: Scene, mode: OverlayMode): Scene {
  const split = scene.overlay && scene.overlay.split > 0 ? scene.overlay.split : 0.5;
  return edited(scene, mode === OverlayMode.SPLIT ? { mode, split } : { mode });
}

/** Returns the name of the built-in look in which the second scan is shown, or null. */
export function overlayLookOf(scene: Scene, looks: readonly OverlayLook[]): string | null {
  const shown = scene.overlay?.transferFunction;
  if (!shown) return null;
  const isShown = ({ overlay }: OverlayLook) =>
    overlay?.transferFunction !== undefined && equals(TransferFunctionSchema, overlay.transferFunction, shown);
  return looks.find(isShown)?.name ?? null;
}
