import { camera_of, camera_to_json, same_but_for_camera, scene_to_json, type Scene, type Viewport } from "../protocol/messages";

const longest_pause_ms = 10_000;
/** Of one recording; what follows is another. */
const most_events = 4000;
const most_bytes = 500_000;

interface Kept {
  readonly at_ms: number;
  readonly scene?: unknown;
  readonly camera?: unknown;
}

/** docs/contracts.md, "Recorded interaction". */
export interface Recording {
  readonly format: "diaphane-interaction";
  readonly version: 1;
  readonly viewport: Viewport;
  readonly events: readonly Kept[];
}

/**
 * Turns the scenes of one viewer into recordings: what was shown and when, not of whom, by whom or on which day.
 * Knows no clock and sends nothing.
 */
export class Recorder {
  private events_: Kept[] = [];
  private bytes_ = 0;
  private last_: Scene | null = null;
  private last_ms_ = 0;
  private at_ms_ = 0;

  /** A recording that is complete with what came before, or nothing. */
  add(scene: Scene, now_ms: number, viewport: Viewport): Recording | null {
    const full = this.events_.length >= most_events || this.bytes_ >= most_bytes ? this.take(viewport) : null;
    const first = this.last_ === null;
    this.at_ms_ = first ? 0 : this.at_ms_ + Math.round(Math.min(Math.max(0, now_ms - this.last_ms_), longest_pause_ms));
    const camera_alone = this.last_ !== null && camera_of(scene) !== null && same_but_for_camera(this.last_, scene);
    const text = camera_alone ? camera_to_json(scene) : scene_to_json(scene);
    this.bytes_ += text.length;
    this.events_.push({ at_ms: this.at_ms_, [camera_alone ? "camera" : "scene"]: JSON.parse(text) as unknown });
    this.last_ = scene;
    this.last_ms_ = now_ms;
    return full;
  }

  /** All that there is; nothing when a picture was only looked at. */
  take(viewport: Viewport): Recording | null {
    const events = this.events_;
    this.events_ = [];
    this.bytes_ = 0;
    this.last_ = null;
    if (events.length < 2) return null;
    return { format: "diaphane-interaction", version: 1, viewport: { width: viewport.width, height: viewport.height }, events };
  }
}
