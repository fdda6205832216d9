import { effect, signal } from "@preact/signals";
import { isSamePose, type CameraPose } from "../input/camera";
import { eased } from "../input/camera_path";
import { cameraOf, withCamera, type Scene } from "../protocol/messages";
import type { SceneEditor } from "./scene_editor";

export interface MotionParts {
  readonly editor: Pick<SceneEditor, "scene" | "change" | "follow" | "rest">;
  readonly nextFrame: (task: () => void) => void;
  readonly nowMs: () => number;
  /** Whether the user prefers reduced motion. */
  readonly isCalm: () => boolean;
}

/** Returns the next camera, given the milliseconds since the last one, or null once the motion has ended. */
export type Step = (elapsedMs: number) => CameraPose | null;

const flightMs = 450;

/** Moves the camera over time. Ends as soon as anything else moves it. */
export class CameraMotion {
  readonly moving = signal(false);
  /** Whether the camera moves because the window changes its shape, which ends no motion. */
  private resizing = false;
  private set: CameraPose | null = null;
  private run = 0;
  private ended: () => void = () => undefined;
  private readonly stopWatching: () => void;

  constructor(private readonly parts: MotionParts) {
    this.stopWatching = effect(() => {
      const scene = parts.editor.scene.value;
      const pose = scene && cameraOf(scene);
      if (this.resizing) this.set = this.set && pose;
      else if (this.set && !(pose && isSamePose(pose, this.set))) this.end();
    });
  }

  /** Moves the camera to a pose, at once if the user prefers reduced motion. */
  flyTo(to: CameraPose, what: string): void {
    const scene = this.parts.editor.scene.peek();
    const from = scene && cameraOf(scene);
    if (!from || isSamePose(from, to)) return;
    let elapsed = this.parts.isCalm() ? flightMs : 0;
    this.start(what, (ms) => {
      if (elapsed > flightMs) return null;
      elapsed += ms;
      const pose = eased(from, to, Math.min(1, elapsed / flightMs));
      if (elapsed >= flightMs) elapsed = Infinity;
      return pose;
    });
  }

  /** Moves the camera by `step` once per screen refresh. `what` names the undo step. */
  start(what: string, step: Step, ended: () => void = () => undefined): void {
    this.stop();
    this.ended = ended;
    this.moving.value = true;
    const run = this.run;
    let beforeMs = this.parts.nowMs();
    const next = () => {
      if (run !== this.run) return;
      const nowMs = this.parts.nowMs();
      const pose = step(nowMs - beforeMs);
      beforeMs = nowMs;
      if (!pose) {
        this.stop();
        return;
      }
      this.apply(what, pose);
      if (run === this.run) this.parts.nextFrame(next);
    };
    next();
  }

  /** Stops where the camera is. */
  stop(): void {
    if (!this.moving.peek()) return;
    this.end();
    this.parts.editor.rest();
  }

  /** Runs `resize`, which may reframe the picture for a window of another shape. */
  during(resize: () => void): void {
    this.resizing = true;
    resize();
    this.resizing = false;
  }

  close(): void {
    this.end();
    this.stopWatching();
  }

  private apply(what: string, pose: CameraPose): void {
    if (this.set && isSamePose(pose, this.set)) return;
    const edit = (scene: Scene) => withCamera(scene, pose);
    const isFirst = this.set === null;
    this.set = pose;
    // Later frames make no step, because edits between them would end the step of the motion.
    if (isFirst) this.parts.editor.change(what, edit, true);
    else this.parts.editor.follow(edit);
    const scene = this.parts.editor.scene.peek();
    const now = scene && cameraOf(scene);
    if (now && !isSamePose(now, pose)) this.end(); // another participant presents by now
  }

  private end(): void {
    this.run += 1;
    this.set = null;
    this.moving.value = false;
    const { ended } = this;
    this.ended = () => undefined;
    ended();
  }
}
