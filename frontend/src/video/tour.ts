import { effect, signal } from "@preact/signals";
import type { ScanTour } from "../api/studies";
import { isSamePose, type CameraPose } from "../input/camera";
import { advanced, cameraAt, keyCameras, refittedPath, tourOf, type CameraPath } from "../input/camera_path";
import { restsOf, tourThrough } from "../input/view_tour";
import type { After } from "../live/paced";
import type { GoodViews } from "../protocol/gen/api/proto/stream_pb";
import { cameraOf, plain, withCamera, type Scene } from "../protocol/messages";
import type { CameraMotion } from "./camera_motion";
import type { SceneEditor } from "./scene_editor";

export interface TourParts {
  readonly editor: Pick<SceneEditor, "scene">;
  readonly motion: Pick<CameraMotion, "start" | "stop">;
  /** Loads the tour that a study found for the scan. Null if there is none. */
  readonly loadStudy: () => Promise<ScanTour | null>;
  /** Asks the worker for good views of the scene. Returns false without a connection. */
  readonly ask: () => boolean;
  readonly isConnected: () => boolean;
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
export type TourFault = "nothing" | "unanswered" | "disconnected";

/** Views, null without an answer, or "stopped" if nobody waits for it anymore. */
type Answer = GoodViews | null | "stopped";

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
  /** The tour of a study, once it is loaded. */
  readonly study = signal<ScanTour | null>(null);
  private loading: Promise<ScanTour | null> | null = null;
  private path: CameraPath | null = null;
  private at = 0;
  private shown = 0;
  /** Where along the path the camera was at each input that is not shown yet. */
  private sent: { readonly input: number; readonly at: number }[] = [];
  private resizing = false;
  /** The scene of the tour. A change of anything but the camera may show matter where the path leads. */
  private scene: Scene | null = null;
  private pausedAt: CameraPose | null = null;
  /** Counts starts and stops, so that an answer to a stopped tour is ignored. */
  private run = 0;
  private answered: (views: Answer) => void = () => undefined;
  private readonly stopWatching: () => void;

  constructor(private readonly parts: TourParts) {
    this.stopWatching = effect(() => {
      const scene = parts.editor.scene.value;
      const pose = poseOfScene(scene);
      if (this.scene && !(scene && sameMatter(this.scene, scene))) this.stop();
      else if (this.resizing) this.pausedAt = this.pausedAt && pose;
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
    const run = ++this.run;
    const scene = this.parts.editor.scene.peek();
    const path = await this.findPath();
    if (run !== this.run) return; // stopped meanwhile, and maybe started again
    this.state.value = "off";
    const now = this.parts.editor.scene.peek();
    if (path && scene && now && sameMatter(scene, now)) this.begin(path, now);
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
    this.settle();
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

  /** Loads the tour of a study once. Without an answer, the next call tries again. */
  loadStudy(): Promise<ScanTour | null> {
    this.loading ??= this.parts.loadStudy().then(
      (found) => (this.study.value = found),
      () => (this.loading = null),
    );
    return this.loading;
  }

  /** Uses computed views again, because the owner of the scan removed those of the study. */
  forgetStudy(): void {
    this.stop();
    this.study.value = null;
    this.loading = Promise.resolve(null);
  }

  receive(views: GoodViews | null): void {
    this.answered(views);
  }

  close(): void {
    this.end();
    this.settle();
    this.stopWatching();
  }

  private async findPath(): Promise<CameraPath | null> {
    this.fault.value = null;
    const { run } = this;
    const study = await this.loadStudy();
    if (run !== this.run) return null;
    const chosen = study && poseOfScene(this.parts.editor.scene.peek());
    if (study && chosen) return tourThrough(chosen, study.views, this.parts.aspect());
    const views = await this.askForViews();
    if (views === "stopped") return null;
    const pose = poseOfScene(this.parts.editor.scene.peek());
    if (views && pose && views.views.length > 0 && views.low && views.high) {
      const directions = views.views.map((view) => ({
        azimuth: view.azimuth * degree,
        elevation: view.elevation * degree,
      }));
      const subject = { low: plain(views.low), high: plain(views.high) };
      return tourOf(pose, directions, subject, this.parts.aspect());
    }
    this.fault.value = views ? "nothing" : this.parts.isConnected() ? "unanswered" : "disconnected";
    return null;
  }

  private askForViews(): Promise<Answer> {
    this.settle();
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

  /** Ends a request that nobody waits for, without a message. */
  private settle(): void {
    this.answered("stopped");
  }

  private begin(path: CameraPath, scene: Scene): void {
    this.path = path;
    this.scene = scene;
    this.at = 0;
    this.move();
  }

  private move(): void {
    if (!this.path) return;
    this.sent = [];
    this.shown = this.at;
    this.state.value = "moving";
    const step = this.parts.isCalm() ? (ms: number) => this.nextStill(ms) : (ms: number) => this.next(ms);
    this.parts.motion.start("tour", step, () => {
      if (this.state.peek() === "moving") this.end();
    });
  }

  private next(elapsedMs: number): CameraPose | null {
    const { path } = this; // of the window's current shape
    if (!path || this.at >= (path.stops.at(-1) ?? 0)) return null;
    const shownInput = this.parts.shownInput();
    for (const { input, at } of this.sent) if (input <= shownInput) this.shown = Math.max(this.shown, at);
    this.sent = this.sent.filter(({ input }) => input > shownInput);
    this.at = advanced(path, this.at, elapsedMs, this.shown);
    // The next input carries this camera, whether it is sent now or with the next screen refresh.
    const input = this.parts.sentInput() + 1;
    if (this.sent.at(-1)?.input === input) this.sent.pop();
    this.sent.push({ input, at: this.at });
    return cameraAt(path, this.at);
  }

  /** Shows views one after the other without motion between them. Here, `at` is the time in ms. */
  private nextStill(elapsedMs: number): CameraPose | null {
    if (!this.path) return null;
    // A hidden page gets no frames. It continues with the view that it left.
    this.at += Math.min(Math.max(elapsedMs, 0), stillMs);
    const views = this.study.peek() ? restsOf(this.path) : keyCameras(this.path, stillViews + 1);
    return views[Math.floor(this.at / stillMs)] ?? null;
  }

  private end(): void {
    this.run += 1;
    this.pausedAt = null;
    this.path = null;
    this.scene = null;
    this.state.value = "off";
  }
}

/** Whether two scenes show the same, apart from the camera and the phase. Edits replace only the parts that they change. */
function sameMatter(a: Scene, b: Scene): boolean {
  const keys = Object.keys({ ...a, ...b }) as (keyof Scene)[];
  return keys.every((key) => key === "camera" || key === "volumePhase" || a[key] === b[key]);
}

const poseOfScene = (scene: Scene | null): CameraPose | null => scene && cameraOf(scene);
