import type { ScanTour } from "../api/studies";
import type { CameraPose } from "../input/camera";
import { poseFromSide } from "../input/cube";
import type { After } from "../live/paced";
import { cameraOf, type Viewport } from "../protocol/messages";
import { CameraMotion } from "./camera_motion";
import type { SceneEditor } from "./scene_editor";
import { Tour } from "./tour";

export interface GuideParts {
  readonly editor: SceneEditor;
  readonly leads: () => boolean;
  /** Whether this viewer presents. One with a free camera leads, but gets no views for a tour. */
  readonly presents: () => boolean;
  readonly canvasSize: () => Viewport;
  /** Loads the tour that a study found for the scan. Null if there is none. */
  readonly loadStudy: () => Promise<ScanTour | null>;
  /** Asks the worker for good views of the scene. Returns false without a connection. */
  readonly askForViews: () => boolean;
  readonly isConnected: () => boolean;
  /** The newest input that was sent, and the one that the picture on the screen shows. */
  readonly sentInput: () => number;
  readonly shownInput: () => number;
  readonly after: After;
}

const isCalm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

/** Moves the presenter's camera on its own: to standard views, and on a tour. */
export class GuidedCamera {
  readonly tour: Tour;
  private readonly motion: CameraMotion;

  constructor(private readonly parts: GuideParts) {
    const { editor } = parts;
    this.motion = new CameraMotion({
      editor,
      nextFrame: (task) => requestAnimationFrame(task),
      nowMs: () => performance.now(),
      isCalm,
    });
    this.tour = new Tour({
      ...parts,
      leads: () => parts.leads() && parts.presents(),
      motion: this.motion,
      ask: parts.askForViews,
      aspect: () => parts.canvasSize().width / parts.canvasSize().height,
      isCalm,
    });
  }

  /** Turns the picture to a side of the patient, framed as at the start. `letter` is that of the orientation cube. */
  viewFrom(letter: string): void {
    this.fly(this.parts.editor.home(), letter);
  }

  /** Turns the picture to a side of the patient, and keeps what it looks at, the zoom and the lens. */
  turnTo(letter: string): void {
    const scene = this.parts.editor.scene.peek();
    this.fly(scene && cameraOf(scene), letter);
  }

  private fly(pose: CameraPose | null, letter: string): void {
    if (!pose || !this.parts.leads()) return;
    this.tour.stop();
    this.motion.flyTo(poseFromSide(pose, letter), `side ${letter}`);
  }

  /** Runs `resize`, which may reframe the picture for a window of another shape. A tour continues in the new shape. */
  during(resize: () => void): void {
    this.motion.during(() => this.tour.during(resize));
  }

  close(): void {
    this.tour.close();
    this.motion.close();
  }
}
