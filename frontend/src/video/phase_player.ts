import { signal } from "@preact/signals";
import { phaseAt, phaseOf, usualRate, withPhase, type Phase } from "../scene/phases";
import type { SceneEditor } from "./scene_editor";

export interface PlayerParts {
  readonly editor: Pick<SceneEditor, "scene" | "follow" | "rest">;
  readonly leads: () => boolean;
  readonly nextFrame: (task: () => void) => void;
  readonly nowMs: () => number;
}

/** How many phases the renderer has loaded. */
export interface LoadedPhases {
  readonly loaded: number;
  /** Whether all of them fit in its memory. */
  readonly fit: boolean;
}

/** Chooses and plays the phases of a scan. Playing never starts by itself, and the phase is not an undo step. */
export class PhasePlayer {
  readonly phases = signal<readonly Phase[]>([]);
  readonly playing = signal(false);
  /** In phases per second. */
  readonly rate = signal(1);
  readonly repeats = signal(true);
  readonly loaded = signal<LoadedPhases | null>(null);
  private run = 0;
  private from = 0;
  private begunMs = 0;

  constructor(private readonly parts: PlayerParts) {}

  configured(phases: readonly Phase[]): void {
    const isOther = phases.length !== this.phases.peek().length;
    this.phases.value = phases;
    this.loaded.value = null; // sent next, if there are phases
    if (isOther) this.rate.value = usualRate(phases);
    if (phases.length < 2) this.pause();
  }

  toggle(): void {
    if (this.playing.peek()) this.pause();
    else this.play();
  }

  pause(): void {
    if (!this.playing.peek()) return;
    this.run += 1;
    this.playing.value = false;
    this.parts.editor.rest();
  }

  /** Shows a phase. `held` means that more choices follow at once. */
  choose(phase: number, held = false): void {
    const count = this.phases.peek().length;
    if (count < 2 || !this.parts.leads()) return;
    this.run += 1;
    this.playing.value = false;
    this.show(Math.min(Math.max(Math.round(phase), 0), count - 1));
    if (!held) this.parts.editor.rest();
  }

  /** Goes to the next or the previous phase, around the end. */
  step(by: 1 | -1): void {
    const count = this.phases.peek().length;
    const scene = this.parts.editor.scene.peek();
    if (scene && count > 1) this.choose((phaseOf(scene, count) + by + count) % count);
  }

  setRate(perSecond: number): void {
    this.rate.value = perSecond;
    this.restart(); // at the new rate from here on
  }

  close(): void {
    this.run += 1;
  }

  private play(): void {
    const count = this.phases.peek().length;
    const scene = this.parts.editor.scene.peek();
    if (!scene || count < 2 || !this.parts.leads()) return;
    if (!this.repeats.peek() && phaseOf(scene, count) === count - 1) this.show(0);
    this.playing.value = true;
    this.restart();
    const run = ++this.run;
    const next = () => {
      if (run !== this.run) return;
      this.tick();
      if (run === this.run) this.parts.nextFrame(next);
    };
    this.parts.nextFrame(next);
  }

  private restart(): void {
    const scene = this.parts.editor.scene.peek();
    this.from = scene ? phaseOf(scene, this.phases.peek().length) : 0;
    this.begunMs = this.parts.nowMs();
  }

  private tick(): void {
    if (!this.parts.leads()) {
      this.run += 1;
      this.playing.value = false;
      return;
    }
    const count = this.phases.peek().length;
    const elapsedMs = this.parts.nowMs() - this.begunMs;
    const phase = phaseAt(this.from, elapsedMs, this.rate.peek(), count, this.repeats.peek());
    this.show(phase ?? count - 1);
    if (phase === null) this.pause();
  }

  private show(phase: number): void {
    const scene = this.parts.editor.scene.peek();
    if (scene && scene.volumePhase !== phase) this.parts.editor.follow((now) => withPhase(now, phase));
  }
}
