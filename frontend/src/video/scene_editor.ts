import { signal } from "@preact/signals";
import { applyGesture } from "../input/apply_gesture";
import { fittedToAspect, refitted, type CameraPose } from "../input/camera";
import type { Gesture } from "../input/gestures";
import {
  cameraOf,
  sameLook,
  sameScene,
  withCamera,
  type Config,
  type Preset,
  type Scene,
  type Viewport,
} from "../protocol/messages";
import { changed, nothingYet, redone, rested, undone, type History, type Moved } from "../scene/history";
import { resetPart, type Part } from "../scene/parts";

/** What the editor needs of the session. */
export interface EditorParts {
  /** Whether this viewer controls the scene. */
  readonly leads: () => boolean;
  readonly canvasSize: () => Viewport;
  /** Sends an edited scene. `rest`: no further edit follows at once. */
  readonly send: (scene: Scene, rest: boolean) => void;
  /** Sends that the last edit is finished. */
  readonly rest: () => void;
}

/** The scene of one session, its edits and the steps to undo. */
export class SceneEditor {
  readonly scene = signal<Scene | null>(null);
  readonly presets = signal<readonly Preset[]>([]);
  /** The steps to undo and to redo. */
  readonly steps = signal<History<Scene>>(nothingYet);
  /** The scene at the start of the session: the look that the scan's owner chose, or the volume's default. */
  readonly begun = signal<Scene | null>(null);

  constructor(private readonly parts: EditorParts) {}

  /** Shows a scene that was not edited here, and forgets all steps. */
  replace(scene: Scene | null): void {
    this.scene.value = scene;
    this.forgetSteps();
  }

  forgetSteps(): void {
    this.steps.value = nothingYet;
  }

  /** `untouched` means that nobody has edited the scene of this session yet. */
  configured(config: Config, untouched: boolean): void {
    this.presets.value = config.presets;
    const before = this.scene.value;
    if (!before || !config.scene || !sameScene(before, config.scene)) this.forgetSteps(); // the scene was changed elsewhere
    this.scene.value = config.scene ?? null;
    if (untouched) this.begun.value = config.scene ?? null;
    const { width, height } = this.parts.canvasSize();
    const home = untouched && width < height ? this.home() : null;
    if (home && config.scene) this.setScene(withCamera(config.scene, home), null, true);
  }

  /** `held` means that the pointer is still down. */
  act(gesture: Gesture, held = false): void {
    const scene = this.scene.value;
    const pose = scene && cameraOf(scene);
    if (scene && pose) this.setScene(withCamera(scene, applyGesture(pose, gesture)), { what: "camera", held });
  }

  /** Edits the scene. `what` names the changed setting. While it is held, all edits form one undo step. */
  change(what: string, edit: (scene: Scene) => Scene, held = false): void {
    const scene = this.scene.value;
    const edited = scene && edit(scene);
    if (edited && edited !== scene) this.setScene(edited, { what, held });
  }

  /** Ends a gesture. */
  rest(): void {
    this.steps.value = rested(this.steps.value);
    this.parts.rest();
  }

  undo(): void {
    this.go(undone);
  }

  redo(): void {
    this.go(redone);
  }

  /** Resets one part to what the session began with. */
  reset(part: Part): void {
    const begun = this.begun.value ?? (this.activePreset() ?? this.presets.value[0])?.scene;
    if (begun) this.change(`reset ${part}`, (scene) => resetPart(scene, begun, part));
  }

  private go(way: (steps: History<Scene>, now: Scene) => Moved<Scene> | null): void {
    const scene = this.scene.value;
    const moved = scene && this.parts.leads() ? way(this.steps.value, scene) : null;
    if (!moved) return;
    this.setScene(moved.value, null, true);
    this.steps.value = moved.history;
  }

  /** Applies a look but keeps the camera, the lens and the cuts. */
  applyPreset(preset: Preset): void {
    if (!preset.scene) return;
    const now = this.scene.value;
    const kept = {
      ...(now?.camera ? { camera: now.camera } : {}),
      ...(now?.clip ? { clip: now.clip } : {}),
      ...(now?.slices ? { slices: now.slices } : {}),
      ...(now ? { showTable: now.showTable } : {}),
    };
    this.setScene({ ...preset.scene, ...kept }, { what: `preset ${preset.name}`, held: false }, true);
  }

  /** Starts with a look and its own camera. */
  beginWith(preset: Preset): void {
    const pose = preset.scene && cameraOf(preset.scene);
    if (preset.scene) this.setScene(pose ? withCamera(preset.scene, this.fitted(pose)) : preset.scene, null, true);
  }

  /** Replaces the whole scene: look, lights, cuts and camera. */
  showScene(scene: Scene): void {
    this.setScene(scene, { what: "scene", held: false }, true);
  }

  /** Keeps the subject in the picture when the window, or what lies beside the picture, changes its shape. No step to undo. */
  resized(before: Viewport, after: Viewport): void {
    const scene = this.scene.value;
    const pose = scene && cameraOf(scene);
    if (!scene || !pose) return;
    const fitted = refitted(pose, before.width / before.height, after.width / after.height);
    if (fitted !== pose) this.setScene(withCamera(scene, fitted), null, true);
  }

  /** The same with another clip, while a hand moves it or (`rest`) has moved it. */
  cutScene(scene: Scene, rest: boolean): void {
    this.setScene(scene, null, rest);
  }

  /** Resets the camera to that of the preset. */
  resetCamera(): void {
    const scene = this.scene.value;
    const home = this.home();
    if (scene && home) this.setScene(withCamera(scene, home), { what: "home", held: false }, true);
  }

  activePreset(): Preset | null {
    const scene = this.scene.value;
    return (scene && this.presets.value.find((preset) => preset.scene && sameLook(preset.scene, scene))) ?? null;
  }

  private home(): CameraPose | null {
    const scene = this.scene.value;
    const first = this.begun.value;
    const same = scene && first && sameLook(first, scene) ? first : null;
    const begun = same ?? (this.activePreset() ?? this.presets.value[0])?.scene;
    const pose = begun && cameraOf(begun);
    return pose ? this.fitted(pose) : null;
  }

  private fitted(pose: CameraPose): CameraPose {
    const { width, height } = this.parts.canvasSize();
    return fittedToAspect(pose, width / height);
  }

  /** `change` describes the undo step. Null for none. */
  private setScene(scene: Scene, change: { readonly what: string; readonly held: boolean } | null, rest = false): void {
    if (!this.parts.leads()) return; // a follower cannot edit
    const before = this.scene.value;
    if (change && before) this.steps.value = changed(this.steps.value, before, { ...change, nowMs: performance.now() });
    this.scene.value = scene;
    this.parts.send(scene, rest);
  }
}
