import { VolumePhase_Kind as PhaseKind, type VolumePhase } from "../protocol/gen/api/proto/volume_pb";
import type { Scene } from "../protocol/messages";

export { PhaseKind };
export type Phase = Pick<VolumePhase, "kind" | "value">;

/** The rates to choose from, in phases per second. */
export const phaseRates = [1, 2, 3, 5, 8, 10, 15, 20, 25, 30] as const;

/** Times closer together than this are played as fast as they were recorded. */
const shortestPauseMs = 250;
/** A series that is played faster or slower than it was recorded takes about this long. */
const usualSeconds = 4;

/** Returns the phase of the scan that a scene shows: the last one if the scan has fewer. */
export const phaseOf = (scene: Pick<Scene, "volumePhase">, count: number): number =>
  Math.min(scene.volumePhase, Math.max(count, 1) - 1);

export const withPhase = (scene: Scene, volumePhase: number): Scene =>
  scene.volumePhase === volumePhase ? scene : { ...scene, volumePhase };

/** Returns the rate at which a scan is played at first: a heartbeat in one second, and other times as they were. */
export function usualRate(phases: readonly Phase[]): number {
  return nearest(wantedRate(phases));
}

function wantedRate(phases: readonly Phase[]): number {
  const [first, last] = [phases[0], phases.at(-1)];
  if (!first || !last || phases.length < 2) return 1;
  switch (first.kind) {
    case PhaseKind.CYCLE:
      return phases.length;
    case PhaseKind.TIME: {
      const pauseMs = (last.value - first.value) / (phases.length - 1);
      return pauseMs > 0 && pauseMs <= shortestPauseMs ? 1000 / pauseMs : phases.length / usualSeconds;
    }
    case PhaseKind.ECHO:
    case PhaseKind.B_VALUE:
      return 2;
    case PhaseKind.INDEX:
      return Math.min(phases.length, 20);
  }
}

const nearest = (rate: number): number =>
  phaseRates.reduce<number>((best, one) => (Math.abs(one - rate) < Math.abs(best - rate) ? one : best), phaseRates[0]);

/**
 * Returns the phase to show `elapsedMs` after `from`, or null after the last one if the phases are not repeated. Phases
 * that a slow renderer cannot show are skipped, so that the speed stays right.
 */
export function phaseAt(
  from: number,
  elapsedMs: number,
  perSecond: number,
  count: number,
  repeats: boolean,
): number | null {
  const at = from + Math.floor((Math.max(elapsedMs, 0) * perSecond) / 1000);
  if (at < count) return at;
  return repeats ? at % count : null;
}
