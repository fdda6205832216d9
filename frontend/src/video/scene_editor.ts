import { signal } from "@preact/signals";
import { applyGesture } from "../input/apply_gesture";
import { isSamePose, refitted, type CameraPose } from "../input/camera";
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
import { comfortOf, hasComfort, originalsOf, setComfort, type Originals } from "../scene/comfort";
import { labelsAfter } from "../scene/labels";
import { withPhase } from "../scene/phases";
import { resetPart, type Part } from "../scene/parts";

/** The part of the session that the editor needs. */
export interface EditorParts {
  /** Whether this viewer controls the scene. */
  readonly leads: () => boolean;
  readonly canvasSize: () => Viewport;
  /** Sends an edited scene. `rest`: no further edit follows at once. */
  readonly send: (scene: Scene, rest: boolean) => void;
  /** Reports that the last edit is finished. */
  readonly rest: () => void;
  /** Returns the scene to begin with in place of the server's, as presets keep it, or null. */
  readonly firstScene?: (scene: Scene) => Scene | null;
}

/** Saved scenes are framed for this shape, and for every wider one: the camera's field of view is vertical. */
const square: Viewport = { width: 1, height: 1 };

/** Moves the camera so that a picture of another shape shows as much. */
function reframed(scene: Scene, before: Viewport, after: Viewport): Scene {
  const pose = cameraOf(scene);
  const fitted = pose && refitted(pose, before.width / before.height, after.width / after.height);
  return fitted && fitted !== pose ? withCamera(scene, fitted) : scene;
}

/** The scene of one session, its edits and the steps to undo. */
export class SceneEditor {
  readonly scene = signal<Scene | null>(null);
  readonly presets = signal<readonly Preset[]>([]);
  /** The steps to undo and to redo. */
  readonly steps = signal<History<Scene>>(nothingYet);
  /** The scene at the start of the session: the look that the scan's owner chose, or the volume's default. */
  readonly begun = signal<Scene | null>(null);
  /**
   * Called after each edit, so that a linked picture can follow. `rest`: no further edit follows at
   * once. Changes by the server, or for a window of another shape, are not edits.
   */
  edited: (rest: boolean) => void = () => undefined;

  constructor(private readonly parts: EditorParts) {}

  /** Shows a scene that was not edited here, and forgets all steps. */
  replace(scene: Scene | null): void {
    this.scene.value = scene;
    this.forgetSteps();
  }

  forgetSteps(): void {
    this.steps.value = nothingYet;
  }

  /**
   * Takes over the scene of a new connection. `untouched` means that nobody has edited the scene of
   * this session yet. Returns whether it was edited here, to fit into a narrow window or to begin with another one.
   */
  configured(config: Config, untouched: boolean): boolean {
    this.presets.value = config.presets;
    const before = this.scene.value;
    if (!before || !config.scene || !sameScene(before, config.scene)) this.forgetSteps(); // the scene was changed elsewhere
    this.scene.value = config.scene ?? null;
    if (untouched) this.begun.value = config.scene ?? null;
    const first = (untouched && config.scene && this.parts.firstScene?.(config.scene)) ?? null;
    if (first) {
      this.begun.value = first;
      this.showAndSend(this.framed(first), true);
      return true;
    }
    const { width, height } = this.parts.canvasSize();
    const home = untouched && width < height ? this.home() : null;
    if (!home || !config.scene) return false;
    this.showAndSend(withCamera(config.scene, home), true);
    return true;
  }

  /** Applies a gesture to the camera. `held` means that the pointer is still down. */
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

  /** Continues a motion whose undo step exists already, or shows another phase, which has none. */
  follow(edit: (scene: Scene) => Scene): void {
    const scene = this.scene.value;
    if (scene) this.setScene(edit(scene), null);
  }

  /** Ends a gesture. */
  rest(): void {
    this.steps.value = rested(this.steps.value);
    this.parts.rest();
    if (this.parts.leads()) this.edited(true);
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

  private go(step: (steps: History<Scene>, now: Scene) => Moved<Scene> | null): void {
    const scene = this.scene.value;
    const moved = scene && this.parts.leads() ? step(this.steps.value, scene) : null;
    if (!scene || !moved) return;
    // The phase is where the viewer is in time, and no edit.
    this.setScene(withPhase(moved.value, scene.volumePhase), null, true);
    this.steps.value = moved.history;
  }

  /**
   * Applies a look but keeps the cuts, the slices, the second scan, the phase, what the user has changed about labels
   * and whether the table is shown. The camera stays once somebody has moved it. Until then, the look
   * brings its own, because the look of a part is framed on that part.
   */
  applyPreset(preset: Preset): void {
    if (!preset.scene) return;
    const now = this.scene.value;
    const kept = {
      ...(now?.camera && !this.isHome() ? { camera: now.camera } : {}),
      ...(now?.clip ? { clip: now.clip } : {}),
      ...(now?.slices ? { slices: now.slices } : {}),
      ...(now?.overlay ? { overlay: now.overlay } : {}),
      ...(now
        ? {
            showTable: now.showTable,
            volumePhase: now.volumePhase,
            labels: labelsAfter(now, this.shownPresets(), preset.scene),
          }
        : {}),
    };
    this.setScene(
      { ...this.framed(this.inComfort(preset.scene)), ...kept },
      { what: `preset ${preset.name}`, held: false },
      true,
    );
  }

  /** Starts with a look and its own camera. */
  beginWith(preset: Preset): void {
    if (preset.scene) this.setScene(this.framed(preset.scene), null, true);
  }

  /** Replaces the whole scene by a saved one: look, lights, cuts and camera. */
  showScene(saved: Scene): void {
    this.setScene(this.framed(saved), { what: "scene", held: false }, true);
  }

  /** Returns a saved scene as this window shows it. */
  framed(saved: Scene): Scene {
    return reframed(saved, square, this.parts.canvasSize());
  }

  /** Returns the scene as presets and links keep it, so that a window of any shape shows the whole subject. */
  toSave(): Scene | null {
    const scene = this.scene.value;
    return scene && reframed(scene, this.parts.canvasSize(), square);
  }

  /**
   * Keeps the subject in view when the picture changes its shape: with the window or the panels next to it, or because
   * someone in another window presents from now on. Not an undo step. Returns whether the camera has
   * moved.
   */
  resized(before: Viewport, after: Viewport): boolean {
    const scene = this.scene.value;
    if (!scene || !this.parts.leads()) return false;
    const fitted = (one: Scene) => reframed(one, before, after);
    if (fitted(scene) === scene) return false;
    this.showAndSend(fitted(scene), true);
    const { past, future, open } = this.steps.value;
    this.steps.value = { past: past.map(fitted), future: future.map(fitted), open };
    return true;
  }

  /** Sets the clip while the user drags it, and once more when they release it (`rest`). */
  cutScene(scene: Scene, rest: boolean): void {
    this.setScene(scene, null, rest);
  }

  /** Resets the camera to that with which the session began, or else to that of the preset. */
  resetCamera(): void {
    const scene = this.scene.value;
    const home = this.home();
    if (scene && home) this.setScene(withCamera(scene, home), { what: "home", held: false }, true);
  }

  /** Returns the shown look, in any comfort. */
  activePreset(): Preset | null {
    const scene = this.scene.value;
    const isShown = (look: Scene) => scene !== null && sameLook(this.inComfort(look), scene);
    return this.presets.value.find((preset) => preset.scene && isShown(preset.scene)) ?? null;
  }

  /** How blood and bone are coloured, from -2 to 2 (scene/comfort.ts). */
  comfort(): number {
    const scene = this.scene.value;
    return scene ? comfortOf(scene, this.originals()) : 0;
  }

  hasComfort(): boolean {
    const scene = this.scene.value;
    return scene !== null && hasComfort(scene, this.originals());
  }

  setComfort(to: number, held: boolean): void {
    this.change("comfort", (scene) => setComfort(scene, this.originals(), to), held);
  }

  private originals(): Originals {
    return originalsOf([this.begun.value ?? undefined, ...this.presets.value.map(({ scene }) => scene)]);
  }

  /** Returns a look in the comfort that the user has chosen. */
  private inComfort(look: Scene): Scene {
    return setComfort(look, this.originals(), this.comfort());
  }

  /** The presets that the scene may come from: any of them if the user has edited its materials. */
  private shownPresets(): readonly Scene[] {
    const active = this.activePreset();
    return (active ? [active] : this.presets.value).flatMap(({ scene }) => scene ?? []);
  }

  /** Whether nobody has moved the camera from where the look placed it. */
  private isHome(): boolean {
    const pose = this.scene.value && cameraOf(this.scene.value);
    const home = this.home();
    return pose !== null && home !== null && isSamePose(pose, home);
  }

  /** Returns the camera with which the session began, or else that of the look. */
  home(): CameraPose | null {
    const scene = this.scene.value;
    const first = this.begun.value;
    const same = scene && first && sameLook(this.inComfort(first), scene) ? first : null;
    const begun = same ?? (this.activePreset() ?? this.presets.value[0])?.scene;
    return begun ? cameraOf(this.framed(begun)) : null;
  }

  /** Sets and sends the scene. `change` describes the undo step, or is null for none. */
  private setScene(scene: Scene, change: { readonly what: string; readonly held: boolean } | null, rest = false): void {
    if (!this.parts.leads()) return; // a follower cannot edit
    const before = this.scene.value;
    if (change && before) this.steps.value = changed(this.steps.value, before, { ...change, nowMs: performance.now() });
    this.showAndSend(scene, rest);
    this.edited(rest);
  }

  private showAndSend(scene: Scene, rest: boolean): void {
    if (!this.parts.leads()) return;
    this.scene.value = scene;
    this.parts.send(scene, rest);
  }
}
