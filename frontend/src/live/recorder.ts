import { cameraOf, cameraToJson, sameButForCamera, sceneToJson, type Scene, type Viewport } from "../protocol/messages";

const longestPauseMs = 10_000;
/** Maximum number of events per recording. Further events start a new one. */
const mostEvents = 4000;
const mostBytes = 500_000;

interface Kept {
  readonly at_ms: number;
  readonly scene?: unknown;
  readonly camera?: unknown;
}

/** A recording in the format of docs/contracts.md, "Recorded interaction". */
export interface Recording {
  readonly format: "diaphane-interaction";
  readonly version: 1;
  readonly viewport: Viewport;
  readonly events: readonly Kept[];
}

/**
 * Turns the scenes of one viewer into recordings of what was shown and when, without the scan, the user or the date.
 * Has no clock and sends nothing.
 */
export class Recorder {
  private events: Kept[] = [];
  private bytes = 0;
  private last: Scene | null = null;
  private lastMs = 0;
  private atMs = 0;

  /** Returns the previous recording if this event starts a new one, else null. */
  add(scene: Scene, nowMs: number, viewport: Viewport): Recording | null {
    const full = this.events.length >= mostEvents || this.bytes >= mostBytes ? this.take(viewport) : null;
    const first = this.last === null;
    this.atMs = first ? 0 : this.atMs + Math.round(Math.min(Math.max(0, nowMs - this.lastMs), longestPauseMs));
    const cameraAlone = this.last !== null && cameraOf(scene) !== null && sameButForCamera(this.last, scene);
    const text = cameraAlone ? cameraToJson(scene) : sceneToJson(scene);
    this.bytes += text.length;
    this.events.push({ at_ms: this.atMs, [cameraAlone ? "camera" : "scene"]: JSON.parse(text) as unknown });
    this.last = scene;
    this.lastMs = nowMs;
    return full;
  }

  /** Ends and returns the current recording, or null if the user only looked at a picture. */
  take(viewport: Viewport): Recording | null {
    const events = this.events;
    this.events = [];
    this.bytes = 0;
    this.last = null;
    if (events.length < 2) return null;
    return {
      format: "diaphane-interaction",
      version: 1,
      viewport: { width: viewport.width, height: viewport.height },
      events,
    };
  }
}
