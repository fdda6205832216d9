import { isSamePose, type CameraPose } from "../input/camera";
import { length, subtract } from "../input/vec3";
import { cameraOf, sameLook, withCamera, type Scene, type Viewport } from "../protocol/messages";
import type { SceneEditor } from "../video/scene_editor";
import { framingOf, inSquare, inverse, movedPoint, movedPose, relativePose, type Motion } from "./mapped_camera";

/** How two pictures are linked: not, by the sides of the patient, or by the same place in the body. */
export type LinkMode = "off" | "sides" | "places";

/** One of the two pictures. */
export interface LinkedPicture {
  readonly editor: SceneEditor;
  readonly viewport: Viewport;
}

type Side = 0 | 1;
const otherOf = (side: Side): Side => (side === 0 ? 1 : 0);

/**
 * Links the cameras and the looks of two pictures. An edit of one changes the other in the same
 * step, so that both are sent at once. Changes that the link makes are not edits, so they do not echo.
 */
export class PictureLink {
  private mode: LinkMode = "off";
  /** Maps the coordinates of the second picture to those of the first, if it is known. */
  private motion: Motion | null = null;
  private changing = false;
  /** The picture that the user has changed last. */
  private last: Side = 0;
  private readonly looks: (Scene | null)[] = [null, null];

  constructor(private readonly pictures: readonly [LinkedPicture, LinkedPicture]) {
    for (const side of [0, 1] as const) {
      this.looks[side] = pictures[side].editor.scene.peek();
      pictures[side].editor.edited = (rest) => this.edited(side, rest);
    }
  }

  /** Links the pictures in another way. The picture that was changed last stays, and the other follows. */
  link(mode: LinkMode, motion: Motion | null): void {
    if (mode === this.mode && motion === this.motion) return;
    this.mode = mode;
    this.motion = motion;
    this.sync();
  }

  /** Turns the other picture to the one that was changed last, for example when both have their first scene. */
  sync(): void {
    this.change(() => this.copyCamera(this.last, true));
  }

  close(): void {
    for (const { editor } of this.pictures) editor.edited = () => undefined;
  }

  private edited(side: Side, rest: boolean): void {
    if (this.changing) return;
    this.last = side;
    this.change(() => {
      this.copyLook(side);
      this.copyCamera(side, rest);
    });
  }

  private change(task: () => void): void {
    if (this.mode === "off") return;
    this.changing = true;
    try {
      task();
    } finally {
      this.changing = false;
    }
  }

  /** Shows the look that was just chosen in the other picture too, if it has one of that name. */
  private copyLook(side: Side): void {
    const { editor } = this.pictures[side];
    const scene = editor.scene.peek();
    const before = this.looks[side];
    this.looks[side] = scene;
    if (!scene || !before || sameLook(before, scene)) return;
    const other = this.pictures[otherOf(side)].editor;
    const name = editor.activePreset()?.name;
    const preset = other.presets.peek().find((one) => one.name === name);
    if (preset && other.activePreset()?.name !== name) other.applyPreset(preset);
  }

  private copyCamera(side: Side, rest: boolean): void {
    const other = this.pictures[otherOf(side)].editor;
    const scene = other.scene.peek();
    const pose = this.poseOfOther(side);
    const now = scene && cameraOf(scene);
    if (pose && now && !isSamePose(now, pose)) other.follow((one) => withCamera(one, pose));
    if (rest && pose) other.rest();
    this.looks[otherOf(side)] = other.scene.peek();
  }

  private poseOfOther(side: Side): CameraPose | null {
    const [from, to] = [this.pictures[side], this.pictures[otherOf(side)]];
    const scene = from.editor.scene.peek();
    const pose = scene && cameraOf(scene);
    if (!pose) return null;
    const map = this.mapFrom(side);
    return map && inSquare(pose, { from: from.viewport, to: to.viewport }, map);
  }

  private mapFrom(side: Side): ((pose: CameraPose) => CameraPose) | null {
    const { motion } = this;
    if (this.mode === "places" && motion) {
      const applied = side === 1 ? motion : inverse(motion);
      return (pose) => movedPose(applied, pose);
    }
    const home = firstCamera(this.pictures[side].editor);
    const otherHome = firstCamera(this.pictures[otherOf(side)].editor);
    if (!home || !otherHome) return null;
    const [from, to] = [framingOf(home), framingOf(otherHome)];
    return (pose) => relativePose(pose, from, to);
  }
}

/** Returns the camera with which a session began, as a square picture has it. */
function firstCamera(editor: SceneEditor): CameraPose | null {
  const scene = editor.begun.peek() ?? editor.presets.peek()[0]?.scene;
  return scene ? cameraOf(scene) : null;
}

/**
 * Whether two aligned scans show about the same region, so that a camera at the same place is of
 * use: the subject of each lies within what the other frames.
 */
export function showSameRegion(first: SceneEditor, second: SceneEditor, motion: Motion): boolean {
  const [a, b] = [firstCamera(first), firstCamera(second)];
  if (!a || !b) return false;
  const apart = length(subtract(movedPoint(motion, b.target), a.target));
  return apart <= Math.max(framingOf(a).size, framingOf(b).size);
}
