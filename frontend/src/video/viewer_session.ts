import { signal } from "@preact/signals";
import type { Place } from "../live/place";
import { apply_gesture } from "../input/apply_gesture";
import { fitted_to_aspect, type CameraPose } from "../input/camera";
import type { Gesture } from "../input/gestures";
import type { Answered } from "../protocol/depth_queries";
import type { KernelReport } from "../protocol/file_messages";
import { open_browser_socket } from "../protocol/browser_socket";
import { first_state, type ConnectionState } from "../protocol/connection";
import {
  camera_of,
  coming_slice,
  SliceAccess,
  same_look,
  same_scene,
  stacks_of,
  with_camera,
  within_bounds,
  type Abilities,
  type Audience,
  type Codec,
  type Config,
  type Frame,
  type Histogram,
  type Preset,
  type Scene,
  type Viewport,
  type VolumeHeader,
} from "../protocol/messages";
import { effort_from, effort_text, full_effort, type Effort } from "../scene/effort";
import { changed, nothing_yet, redone, rested, undone, type History, type Moved } from "../scene/history";
import { Slices, type Access } from "../slices/model";
import { reset_part, type Part } from "../scene/parts";
import { StreamClient } from "../protocol/stream_client";
import { t } from "../texts";
import { tab } from "../storage";
import { SizeTeller } from "./canvas_size";
import { FramePipeline } from "./frame_pipeline";
import { make_decoder } from "./ladder";
import { LosslessEnd, type LosslessFacts } from "./lossless_end";
import type { Painter } from "./painter";
import type { Picture } from "./picture";
import { with_point } from "./plot_scale";
import { sha256 } from "./sha256";
import { decode_still } from "./tile_pixels";
import { remember_view, remembered_view } from "./view_memory";

/** What is known of the picture on the screen. */
export interface PictureFacts {
  readonly epoch: number;
  readonly input_seq: number;
  readonly samples: number;
  /** Relative; infinite while unknown. */
  readonly error: number;
  readonly seconds: number;
  readonly width: number;
  readonly height: number;
  /** The server's denoiser had a part in it: nearer to the finished picture than `error` says. */
  readonly smoothed: boolean;
}

export interface ErrorPoint {
  readonly seconds: number;
  readonly error: number;
}

/** What this browser keeps of what a person prefers. */
export type Preferences = Pick<Storage, "getItem" | "setItem">;

const effort_key = "diaphane.effort";
/** The longest side asked for: what the protocol allows. */
const longest_side = 4096;
const remembered_every_ms = 250;

const slice_access: Readonly<Record<SliceAccess, Access>> = {
  [SliceAccess.NONE]: "none",
  [SliceAccess.CLIPPED]: "clipped",
  [SliceAccess.WHOLE]: "whole",
};

/** One viewer looking at one data set: the stream, the pictures and the scene, without any view. */
export class ViewerSession {
  readonly connection = signal<ConnectionState>(first_state);
  readonly picture = signal<PictureFacts | null>(null);
  readonly curve = signal<readonly ErrorPoint[]>([]);
  readonly converged = signal(false);
  /** The picture on the screen is the renderer's own, pixel by pixel: each tile has been checked. */
  readonly lossless = signal<LosslessFacts | null>(null);
  readonly samples_per_second = signal(0);
  readonly device = signal("");
  /** What renders the picture, once somebody has asked. */
  readonly kernel = signal<KernelReport | null>(null);
  readonly volume = signal<VolumeHeader | null>(null);
  readonly presets = signal<readonly Preset[]>([]);
  readonly scene = signal<Scene | null>(null);
  /** What was before, and what was undone. */
  readonly steps = signal<History<Scene>>(nothing_yet);
  /** What the session began with: the look that the scan's owner chose, or the volume's own. */
  readonly begun = signal<Scene | null>(null);
  /** How often values occur in the volume, where the worker has said so. */
  readonly histogram = signal<Histogram | null>(null);
  /** Who is here, once it is known. */
  readonly audience = signal<Audience | null>(null);
  /** How much work a picture is worth: this person's, whatever is looked at. */
  readonly effort = signal<Effort>(full_effort);
  /** The slices beside the picture. */
  readonly slices = new Slices((lacking, taken) => this.client_.want_slices(lacking, taken));
  /** What the server said about the last input it refused. */
  readonly problem = signal("");

  private readonly client_: StreamClient;
  private readonly pipeline_: FramePipeline<Picture>;
  private readonly lossless_end_: LosslessEnd;
  private readonly size_teller_: SizeTeller;
  private session_id_: string | null;
  private viewport_: Viewport;
  private converged_epoch_ = -1;
  private remembering_: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly place_: Place,
    private readonly painter_: Painter,
    size: Viewport,
    private abilities_: Abilities,
    private readonly preferences_: Preferences,
  ) {
    const before = remembered_view(tab, place_.key);
    this.session_id_ = before.session_id;
    this.viewport_ = within_bounds(size, longest_side);
    this.painter_.resize(this.viewport_);
    const after = (ms: number, task: () => void) => {
      const timer = setTimeout(task, ms);
      return () => clearTimeout(timer);
    };
    const now_ms = () => performance.now();
    this.client_ = new StreamClient(
      {
        door: place_.door(before.session_id, (id) => (this.session_id_ = id)),
        open_socket: open_browser_socket,
        next_frame: (task) => requestAnimationFrame(task),
        after,
        chance: Math.random,
        abilities: this.abilities_,
        pixel_ratio: () => devicePixelRatio,
      },
      {
        connection: (state) => (this.connection.value = state),
        config: (config) => this.configured(config),
        frame: (frame) => {
          this.lossless_end_.epoch_is(frame.epoch);
          this.pipeline_.receive(frame);
        },
        slice: (slice) => {
          const coming = coming_slice(slice);
          if (coming) this.slices.receive(coming);
        },
        slices_stale: () => this.slices.stale(),
        still: (still) => void this.lossless_end_.receive(still),
        state: (state) => {
          this.converged_epoch_ = state.converged ? Number(state.epoch) : -1;
          this.converged.value = this.converged_epoch_ === this.picture.value?.epoch;
        },
        audience: (audience) => {
          this.audience.value = audience;
          this.slices.allow(slice_access[audience.slices]);
          this.painter_.show_whole(!this.client_.leads);
          if (!this.client_.leads) this.steps.value = nothing_yet;
        },
        look: (scene) => {
          this.scene.value = scene;
          this.steps.value = nothing_yet; // they were steps of another's scene
        },
        stats: (stats) => (this.samples_per_second.value = stats.samplesPerSecond),
        problem: ({ field, message }) => (this.problem.value = field === "own_camera" ? t.live.no_own_camera : field === "own_camera_taken" ? t.live.own_camera_taken : message),
        file_progress: () => undefined,
        file_part: () => undefined,
        kernel: (report) => (this.kernel.value = report),
      },
      this.viewport_,
    );
    this.pipeline_ = new FramePipeline<Picture>({
      make_decoder,
      present: (picture, frame) => this.present(picture, frame),
      ack: (frame, times, queue) => this.client_.ack(frame, times, queue),
      need_key: () => this.client_.need_key(),
      give_up: (codec) => this.give_up(codec),
      now_ms,
    });
    this.lossless_end_ = new LosslessEnd({
      decode: decode_still,
      sha256,
      show: (tiles, facts) => {
        const shown = this.painter_.paint_exactly(tiles, facts);
        if (shown) this.present_lossless(facts);
        return shown;
      },
      damaged: () => (this.problem.value = t.viewer.tile_damaged),
      ack: (still, times, queue) => this.client_.ack(still, times, queue),
      now_ms,
    });
    this.size_teller_ = new SizeTeller(this.viewport_, (size) => this.resized(size), { now_ms, after });
    this.begun.value = before.begun;
    const effort = effort_from(preferences_.getItem(effort_key));
    if (effort_text(effort) !== effort_text(full_effort)) this.client_.set_effort((this.effort.value = effort));
    if (before.scene) {
      this.client_.remember(before.scene, before.input_seq);
      this.scene.value = before.scene;
    }
  }

  start(): void {
    this.client_.start();
  }

  /** The page is left for another: the worker's slot is given back; where one was stays known. */
  leave(): void {
    clearTimeout(this.remembering_);
    const id = this.session_id_;
    this.session_id_ = null;
    this.remember();
    this.client_.stop();
    this.size_teller_.stop();
    this.slices.stop();
    this.pipeline_.close();
    this.place_.leave(id);
  }

  get data_set_id(): string | null {
    return this.place_.data_set_id;
  }

  get session_id(): string | null {
    return this.session_id_;
  }

  /** In device pixels. */
  get viewport(): Viewport {
    return this.viewport_;
  }

  hand_over(to: string): void {
    this.client_.hand_over(to);
  }

  /** Whether guests may have the slices, inside the clip. */
  set_guest_slices(on: boolean): void {
    this.client_.set_guest_slices(on);
  }

  use_own_camera(on: boolean): void {
    this.client_.use_own_camera(on);
  }

  /** How far away that is which is seen at a place of the picture, from 0 to 1 from its upper left. */
  depth_at(x: number, y: number): Promise<Answered> {
    return this.client_.depth_at(x, y);
  }

  /** Told in `kernel`, with the next picture. */
  ask_for_kernel(): void {
    this.client_.ask_for_kernel();
  }

  wake(): void {
    this.client_.wake();
  }

  set_visible(visible: boolean): void {
    this.client_.set_visible(visible);
    if (visible) this.client_.wake();
  }

  /** What was shown is gone: the worker sends it anew, as to who has just come. */
  show_anew(): void {
    this.lossless.value = null;
    this.client_.greet_again(this.abilities_);
  }

  /** Of the canvas on the page; it keeps its pixels until a size has settled. */
  resize(size: Viewport): void {
    this.size_teller_.changed(within_bounds(size, longest_side));
  }

  /** `held`: by a hand that will be lifted. */
  act(gesture: Gesture, held = false): void {
    const scene = this.scene.value;
    const pose = scene && camera_of(scene);
    if (scene && pose) this.set_scene(with_camera(scene, apply_gesture(pose, gesture)), { what: "camera", held });
  }

  /** Another scene out of the one there is. `what` is changed; while a hand holds it, that is one step for undoing. */
  change(what: string, edit: (scene: Scene) => Scene, held = false): void {
    const scene = this.scene.value;
    const edited = scene && edit(scene);
    if (edited && edited !== scene) this.set_scene(edited, { what, held });
  }

  /** The hand was lifted. */
  rest(): void {
    this.steps.value = rested(this.steps.value);
    this.client_.rest();
  }

  /** No step for undoing: what is seen in the end is the same. Kept once no hand is on it any more. */
  set_effort(effort: Effort, held = false): void {
    this.effort.value = effort;
    this.client_.set_effort(effort);
    this.remember_soon();
    if (!held) this.keep_effort();
  }

  keep_effort(): void {
    this.preferences_.setItem(effort_key, effort_text(this.effort.value));
  }

  undo(): void {
    this.go(undone);
  }

  redo(): void {
    this.go(redone);
  }

  /** To what the session began with. */
  reset(part: Part): void {
    const begun = this.begun.value ?? (this.active_preset() ?? this.presets.value[0])?.scene;
    if (begun) this.change(`reset ${part}`, (scene) => reset_part(scene, begun, part));
    if (part === "lens") this.set_effort(full_effort);
    this.rest();
  }

  private go(way: (steps: History<Scene>, now: Scene) => Moved<Scene> | null): void {
    const scene = this.scene.value;
    const moved = scene && this.client_.leads ? way(this.steps.value, scene) : null;
    if (!moved) return;
    this.set_scene(moved.value, null, true);
    this.steps.value = moved.history;
  }

  /** Another look at the same place, through the same lens and cut as it is. */
  apply_preset(preset: Preset): void {
    if (!preset.scene) return;
    const now = this.scene.value;
    const kept = { ...(now?.camera ? { camera: now.camera } : {}), ...(now?.clip ? { clip: now.clip } : {}), ...(now?.slices ? { slices: now.slices } : {}) };
    this.set_scene({ ...preset.scene, ...kept }, { what: `preset ${preset.name}`, held: false }, true);
  }

  /** A look, from where it begins. */
  begin_with(preset: Preset): void {
    const pose = preset.scene && camera_of(preset.scene);
    if (preset.scene) this.set_scene(pose ? with_camera(preset.scene, this.fitted(pose)) : preset.scene, null, true);
  }

  /** All of it: look, lights, cuts and where one looks from. */
  show_scene(scene: Scene): void {
    this.set_scene(scene, { what: "scene", held: false }, true);
  }

  /** The same with another clip, while a hand moves it or (`rest`) has moved it. */
  cut_scene(scene: Scene, rest: boolean): void {
    this.set_scene(scene, null, rest);
  }

  /** To the view that the preset began with. */
  reset_camera(): void {
    const scene = this.scene.value;
    const home = this.home();
    if (scene && home) this.set_scene(with_camera(scene, home), { what: "home", held: false }, true);
  }

  active_preset(): Preset | null {
    const scene = this.scene.value;
    return (scene && this.presets.value.find((preset) => preset.scene && same_look(preset.scene, scene))) ?? null;
  }

  png(): Promise<Blob | null> {
    return this.painter_.png();
  }

  /** At once: the page may be about to go. */
  remember(): void {
    remember_view(tab, this.place_.key, {
      session_id: this.session_id_,
      scene: this.scene.value,
      begun: this.begun.value,
      input_seq: this.client_.input_seq,
    });
  }

  private home(): CameraPose | null {
    const scene = this.scene.value;
    const first = this.begun.value;
    const same = scene && first && same_look(first, scene) ? first : null;
    const begun = same ?? (this.active_preset() ?? this.presets.value[0])?.scene;
    const pose = begun && camera_of(begun);
    return pose ? this.fitted(pose) : null;
  }

  private fitted(pose: CameraPose): CameraPose {
    return fitted_to_aspect(pose, this.viewport_.width / this.viewport_.height);
  }

  private resized(size: Viewport): void {
    this.viewport_ = size;
    this.painter_.resize(size);
    this.lossless.value = null; // what is shown until the next picture is scaled
    this.client_.set_viewport(size);
  }

  /** `change`: what it is for undoing; nothing: no step. */
  private set_scene(scene: Scene, change: { readonly what: string; readonly held: boolean } | null, rest = false): void {
    if (!this.client_.leads) return; // a follower looks on
    const before = this.scene.value;
    if (change && before) this.steps.value = changed(this.steps.value, before, { ...change, now_ms: performance.now() });
    this.scene.value = scene;
    this.problem.value = "";
    this.client_.set_scene(scene, rest);
    this.remember_soon();
  }

  private configured(config: Config): void {
    this.pipeline_.reset();
    this.lossless_end_.reset();
    this.converged_epoch_ = -1;
    this.device.value = config.device;
    this.kernel.value = null;
    this.volume.value = config.volume ?? null;
    this.slices.configured(stacks_of(config.sliceStacks), config.volume);
    this.presets.value = config.presets;
    this.histogram.value = config.histogram ?? null;
    const before = this.scene.value;
    if (!before || !config.scene || !same_scene(before, config.scene)) this.steps.value = nothing_yet; // changed elsewhere
    this.scene.value = config.scene ?? null;
    const untouched = !config.follower && config.inputSeq === 0n && this.client_.input_seq === 0;
    if (untouched) this.begun.value = config.scene ?? null;
    const narrow = this.viewport_.width < this.viewport_.height;
    const home = untouched && narrow ? this.home() : null;
    if (home && config.scene) this.set_scene(with_camera(config.scene, home), null, true);
    this.remember_soon();
  }

  /** The next codec of the ladder; the last one is kept, whatever it does. */
  private give_up(codec: Codec): void {
    const codecs = this.abilities_.codecs.filter((one) => one !== codec);
    if (codecs.length === 0) return;
    this.abilities_ = { ...this.abilities_, codecs };
    this.client_.greet_again(this.abilities_);
  }

  private present_lossless(facts: LosslessFacts): void {
    const before = this.picture.value;
    if (before) this.picture.value = { ...before, samples: facts.samples, error: facts.error, width: facts.width, height: facts.height, smoothed: false };
    this.lossless.value = facts;
  }

  private present(picture: Picture, frame: Frame): void {
    if (this.lossless_end_.shows(frame.epoch)) return;
    this.painter_.paint(picture);
    this.lossless.value = null;
    const before = this.picture.value;
    const facts: PictureFacts = {
      epoch: Number(frame.epoch),
      input_seq: Number(frame.inputSeq),
      samples: Number(frame.iteration),
      error: frame.error,
      seconds: Number(frame.renderUs) / 1e6,
      width: frame.width,
      height: frame.height,
      smoothed: frame.denoised,
    };
    this.picture.value = facts;
    const fresh = before?.epoch !== facts.epoch || before.samples > facts.samples;
    this.converged.value = this.converged_epoch_ === facts.epoch;
    this.curve.value = with_point(fresh ? [] : this.curve.value, facts);
  }

  private remember_soon(): void {
    this.remembering_ ??= setTimeout(() => {
      this.remembering_ = undefined;
      this.remember();
    }, remembered_every_ms);
  }
}
