import type { ConnectionState } from "./connection";
import type { ErrorCurve, FilePart, KernelReport } from "./file_messages";
import type { GoodViews, Labels, VolumePhases } from "./gen/api/proto/stream_pb";
import type { MarkSight } from "./mark_messages";
import type { Audience, Config, ExactSlice, Frame, Problem, Scene, State, Stats, Still } from "./messages";
import type { SharedState } from "./shared_messages";

/** What a StreamClient reports. */
export interface StreamEvents {
  connection(state: ConnectionState): void;
  /** Called before any frame of the connection. */
  config(config: Config): void;
  frame(frame: Frame): void;
  still(still: Still): void;
  slice(slice: ExactSlice): void;
  /** The session's clip has changed since the slices arrived. */
  slicesStale(): void;
  /** The participants. This page may have become the presenter, or may no longer be. */
  audience(audience: Audience): void;
  /** The presenter's scene. */
  look(scene: Scene): void;
  state(state: State): void;
  stats(stats: Stats): void;
  problem(problem: Problem): void;
  /** Progress of the ordered file, from 0 to 1. */
  fileProgress(done: number): void;
  filePart(part: FilePart): void;
  // After a request: the kernel that renders the picture, and the error of the current view.
  kernel(report: KernelReport): void;
  errorCurve(curve: ErrorCurve): void;
  /** What the other participants show. */
  shared(shared: SharedState): void;
  markSight(sight: MarkSight): void;
  /** The labels of the scan, whenever they change. */
  labels(labels: Labels): void;
  /** After a request: views for a tour of the scene. */
  goodViews(views: GoodViews): void;
  /** How many phases of the scan the renderer has loaded. */
  volumePhases(phases: VolumePhases): void;
}
