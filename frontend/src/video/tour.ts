import { effect, signal } from "@preact/signals";
import { isSamePose, type CameraPose } from "../input/camera";
import { advanced, cameraAt, keyCameras, refittedPath, tourOf, type CameraPath } from "../input/camera_path";
import type { After } from "../live/paced";
import type { GoodViews } from "../protocol/gen/api/proto/stream_pb";
import { cameraOf, plain, withCamera, type Scene } from "../protocol/messages";
import type { CameraMotion } from "./camera_motion";
import type { SceneEditor } from "./scene_editor";

export interface TourParts {
  readonly editor: Pick<SceneEditor, "scene">;
  readonly motion: Pick<CameraMotion, "start" | "stop">;
  /** Asks the worker for good views of the scene. Returns false without a connection. */
  readonly ask: () => boolean;
  readonly leads: () => boolean;
  readonly aspect: () => number;
  /** The newest input that was sent, and the one that the picture on the screen shows. */
  readonly sentInput: () => number;
  readonly shownInput: () => number;
  readonly after: After;
  readonly isCalm: () => boolean;
}

export type TourState = "off" | "asking" | "moving" | "paused";
/** Why there is no tour. */
export type TourFault = "nothing" | "unanswered";

/** Key views of a video of the tour. */
const videoKeys = 16;
const patienceMs = 5000;
/** For users who prefer reduced motion, the tour shows this many still views for this long each. */
const stillViews = 8;
const stillMs = 4000;
const degree = Math.PI / 180;

/** Shows the presenter around: plays a path of the camera through good views of the scan. */
export class Tour {
  readonly state = signal<TourState>("off");
  readonly fault = signal<TourFault | null>(null);
  private path: CameraPath | null = null;
  private at = 0;
  private shown = 0;
  /** Where along the path the camera was at each input that is not shown yet. */
  private sent: { readonly input: number; readonly at: number }[] = [];
  private resizing = false;
  private pausedAt: CameraPose | null = null;
  private answered: (views: GoodViews | null) => void = () => undefined;
  private readonly stopWatching: () => void;

  constructor(private readonly parts: TourParts) {
    this.stopWatching = effect(() => {
      const pose = poseOfScene(parts.editor.scene.value);
      if (this.resizing) this.pausedAt = this.pausedAt && pose;
      else if (this.pausedAt && !(pose && isSamePose(pose, this.pausedAt))) this.end(); // moved while it was paused
    });
  }

  /** Starts a tour, or stops the current one. */
  async toggle(): Promise<void> {
    if (this.state.peek() !== "off") {
      this.stop();
      return;
    }
    if (!this.parts.leads()) return;
    this.state.value = "asking";
    const path = await this.findPath();
    if (this.asking()) {
      this.state.value = "off";
      if (path) this.begin(path);
    }
  }

  pauseOrContinue(): void {
    if (this.state.peek() === "moving") {
      this.state.value = "paused";
      this.pausedAt = poseOfScene(this.parts.editor.scene.peek());
      this.parts.motion.stop();
    } else if (this.state.peek() === "paused") {
      this.pausedAt = null;
      this.move();
    }
  }

  stop(): void {
    const moved = this.state.peek() === "moving";
    this.end();
    if (moved) this.parts.motion.stop();
  }

  /** Returns the key views of a video of the tour, or null if there is none, with the reason in `fault`. */
  async videoScenes(scene: Scene): Promise<Scene[] | null> {
    const path = this.path ?? (await this.findPath());
    return path && keyCameras(path, videoKeys).map((pose) => withCamera(scene, pose));
  }

  /** Runs `resize`, which reframes the picture for a window of another shape, and the rest of the tour likewise. */
  during(resize: () => void): void {
    const before = this.parts.aspect();
    this.resizing = true;
    resize();
    this.resizing = false;
    if (this.path) this.path = refittedPath(this.path, before, this.parts.aspect());
  }

  receive(views: GoodViews | null): void {
    this.answered(views);
  }

  close(): void {
    this.end();
    this.receive(null);
    this.stopWatching();
  }

  private asking(): boolean {
    return this.state.peek() === "asking";
  }

  private async findPath(): Promise<CameraPath | null> {
    this.fault.value = null;
    const views = await this.askForViews();
    const pose = poseOfScene(this.parts.editor.scene.peek());
    if (views && pose && views.views.length > 0 && views.low && views.high) {
      const directions = views.views.map((view) => ({
        azimuth: view.azimuth * degree,
        elevation: view.elevation * degree,
      }));
      const subject = { low: plain(views.low), high: plain(views.high) };
      return tourOf(pose, directions, subject, this.parts.aspect());
    }
    this.fault.value = views ? "nothing" : "unanswered";
    return null;
  }

  private askForViews(): Promise<GoodViews | null> {
    this.answered(null);
    if (!this.parts.ask()) return Promise.resolve(null);
    return new Promise((resolve) => {
      const disarm = this.parts.after(patienceMs, () => this.answered(null));
      this.answered = (views) => {
        this.answered = () => undefined;
        disarm();
        resolve(views);
      };
    });
  }

  private begin(path: CameraPath): void {
    this.path = path;
    this.at = 0;
    this.move();
  }

  private move(): void {
    const path = this.path;
    if (!path) return;
    this.sent = [];
    this.shown = this.at;
    this.state.value = "moving";
    const step = this.parts.isCalm() ? this.stills(path) : (ms: number) => this.next(path, ms);
    this.parts.motion.start("tour", step, () => {
      if (this.state.peek() === "moving") this.end();
    });
  }

  private next(path: CameraPath, elapsedMs: number): CameraPose | null {
    if (this.at >= (path.stops.at(-1) ?? 0)) return null;
    const shownInput = this.parts.shownInput();
    this.shown = Math.max(this.shown, ...this.sent.filter(({ input }) => input <= shownInput).map(({ at }) => at));
    this.sent = this.sent.filter(({ input }) => input > shownInput);
    this.at = advanced(path, this.at, elapsedMs, this.shown);
    // The next input carries this camera, whether it is sent now or with the next screen refresh.
    this.sent.push({ input: this.parts.sentInput() + 1, at: this.at });
    return cameraAt(path, this.at);
  }

  /** Shows views one after the other without motion between them. */
  private stills(path: CameraPath): (elapsedMs: number) => CameraPose | null {
    const poses = keyCameras(path, stillViews + 1);
    let elapsed = 0;
    return (ms) => {
      elapsed += ms;
      return poses[Math.floor(elapsed / stillMs)] ?? null;
    };
  }

  private end(): void {
    this.pausedAt = null;
    this.path = null;
    this.state.value = "off";
  }
}

const poseOfScene = (scene: Scene | null): CameraPose | null => scene && cameraOf(scene);
