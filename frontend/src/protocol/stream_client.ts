import type { CameraPose } from "../input/camera";
import { advance, first_state, type ConnectionEffect, type ConnectionEvent, type ConnectionState, type Trouble } from "./connection";
import { DepthQueries, type Answered } from "./depth_queries";
import {
  decode_server_message,
  encode_ack,
  encode_handover,
  encode_hello,
  encode_need_key,
  encode_guest_slices,
  encode_own_camera,
  encode_scene,
  encode_slices,
  encode_visibility,
  camera_of,
  with_camera,
  type Abilities,
  type Audience,
  type Config,
  type ExactSlice,
  type Frame,
  type FrameTimes,
  type Problem,
  type Scene,
  type State,
  type Stats,
  type Still,
  type Viewport,
} from "./messages";
import { encode_file, encode_file_taken, encode_kernel_wanted, type FileOrder, type FilePart, type KernelReport } from "./file_messages";
import { full_effort, type Effort } from "../scene/effort";
import type { SliceId } from "../slices/store";

/** Leads to a worker: a one-time address, or why there is none. Asked anew for each try. */
export type Door = (signal: AbortSignal) => Promise<
  | { readonly ok: true; readonly url: string }
  | { readonly ok: false; readonly trouble: Trouble; readonly final: boolean; readonly retry_after_ms?: number }
>;

/** As much of a WebSocket as is used; a test gives its own. */
export interface Socket {
  send(data: Uint8Array<ArrayBuffer>): void;
  close(): void;
}
export interface SocketEvents {
  opened(): void;
  message(data: Uint8Array): void;
  closed(code: number): void;
}
export type OpenSocket = (url: string, events: SocketEvents) => Socket;

export interface Surroundings {
  readonly door: Door;
  readonly open_socket: OpenSocket;
  /** Runs `task` once before the next picture of the screen. */
  readonly next_frame: (task: () => void) => void;
  readonly after: (ms: number, task: () => void) => () => void;
  readonly chance: () => number;
  readonly abilities: Abilities;
  readonly pixel_ratio: () => number;
}

export interface StreamEvents {
  connection(state: ConnectionState): void;
  /** Before any frame of the connection. */
  config(config: Config): void;
  frame(frame: Frame): void;
  still(still: Still): void;
  slice(slice: ExactSlice): void;
  /** The slices that have come are of another clip than the session's now. */
  slices_stale(): void;
  /** Who is here; this page may have become, or may be no more, the presenter's. */
  audience(audience: Audience): void;
  /** The scene as the presenter has it. */
  look(scene: Scene): void;
  state(state: State): void;
  stats(stats: Stats): void;
  problem(problem: Problem): void;
  /** Of the file that was asked for: 0 to 1. */
  file_progress(done: number): void;
  file_part(part: FilePart): void;
  /** What renders the picture, to whoever asked. */
  kernel(report: KernelReport): void;
}

/**
 * Speaks api/proto/stream.proto. Holds the scene as the person wants it: absolute, the newest wins, sent at once but at
 * most once a screen picture, and sent again to a worker that does not have it.
 */
export class StreamClient {
  private state_: ConnectionState = first_state;
  private socket_: Socket | null = null;
  private socket_number_ = 0;
  private disarm_: () => void = () => undefined;
  private asking_: AbortController | null = null;

  private scene_: Scene | null = null;
  private viewport_: Viewport;
  private abilities_: Abilities;
  private visible_ = true;
  private input_seq_ = 0;
  private scene_pending_ = false;
  private rest_pending_ = false;
  private viewport_pending_ = false;
  private effort_ = full_effort;
  private effort_pending_ = false;
  private holding_ = false;
  /** The scene is this page's to change: it presents, or has a camera of its own. */
  private leads_ = true;
  private own_camera_ = false;
  private readonly depths_: DepthQueries;
  /** Where the own camera was before the connection was lost. */
  private own_pose_: CameraPose | null = null;

  constructor(
    private readonly around_: Surroundings,
    private readonly events_: StreamEvents,
    viewport: Viewport,
  ) {
    this.viewport_ = viewport;
    this.abilities_ = around_.abilities;
    this.depths_ = new DepthQueries({ send: (message) => this.say(message), after: around_.after });
  }

  get connection(): ConnectionState {
    return this.state_;
  }

  /** The number of the newest input that has been given. */
  get input_seq(): number {
    return this.input_seq_;
  }

  start(): void {
    this.happened({ kind: "start" });
  }

  stop(): void {
    this.happened({ kind: "stop" });
  }

  /** The network is back, or the page is looked at again: no need to wait longer. */
  wake(): void {
    this.happened({ kind: "wake" });
  }

  /** Before `start`: what an earlier visit wanted last. Said only to a worker that has seen less. */
  remember(scene: Scene, input_seq: number): void {
    this.scene_ = scene;
    this.input_seq_ = input_seq;
  }

  get leads(): boolean {
    return this.leads_;
  }

  hand_over(to: string): void {
    if (this.state_.phase === "live") this.socket_?.send(encode_handover(to));
  }

  /** A camera of one's own, or the presenter's again; also over a reconnection. */
  use_own_camera(on: boolean): void {
    this.own_camera_ = on;
    this.own_pose_ = null;
    if (this.state_.phase === "live") this.socket_?.send(encode_own_camera(on));
  }

  set_guest_slices(on: boolean): void {
    if (this.state_.phase === "live") this.socket_?.send(encode_guest_slices(on));
  }

  set_scene(scene: Scene, rest = false): void {
    if (!this.leads_) return;
    this.scene_ = scene;
    this.scene_pending_ = true;
    this.rest_pending_ = rest;
    this.plan_flush();
  }

  /** Nothing more comes for now (the pointer was lifted): the whole picture need not wait for silence. */
  rest(): void {
    if (!this.leads_) return;
    this.rest_pending_ = true;
    this.plan_flush();
  }

  /** Said to each worker anew. */
  set_effort(effort: Effort): void {
    this.effort_ = effort;
    if (!this.leads_) return;
    this.effort_pending_ = true;
    this.plan_flush();
  }

  set_viewport(viewport: Viewport): void {
    if (viewport.width === this.viewport_.width && viewport.height === this.viewport_.height) return;
    this.viewport_ = viewport;
    this.viewport_pending_ = true;
    this.plan_flush();
  }

  set_visible(visible: boolean): void {
    if (visible === this.visible_) return;
    this.visible_ = visible;
    if (this.state_.phase === "live") this.socket_?.send(encode_visibility(visible));
  }

  /** Greets the worker anew with other abilities, over another connection. The scene stays. */
  greet_again(abilities: Abilities): void {
    this.abilities_ = abilities;
    this.happened({ kind: "again" });
  }

  /** What is lacking now; said again after a reconnection by whoever lacks it. */
  want_slices(lacking: readonly SliceId[], taken: bigint): void {
    if (this.state_.phase === "live") this.socket_?.send(encode_slices(lacking, taken));
  }

  /** How far away that is which is seen at a place of the picture. */
  depth_at(x: number, y: number): Promise<Answered> {
    return this.depths_.ask(x, y);
  }

  /** One at a time; given up with the connection. */
  ask_for_file(order: FileOrder): void {
    for (const message of encode_file(order)) this.say(message);
  }

  file_taken({ seq }: FilePart): void {
    this.say(encode_file_taken(seq));
  }

  ask_for_kernel(): void {
    this.say(encode_kernel_wanted());
  }

  need_key(): void {
    if (this.state_.phase === "live") this.socket_?.send(encode_need_key());
  }

  /** Owed for each frame and still, shown or not: the server keeps about two in flight. */
  ack(frame: Pick<Frame, "seq" | "epoch">, times: FrameTimes, queue: number): void {
    if (this.state_.phase === "live") this.socket_?.send(encode_ack(frame.seq, frame.epoch, times, queue));
    if (times.presented_ms !== undefined) this.happened({ kind: "picture" });
  }

  private say(message: Uint8Array<ArrayBuffer>): boolean {
    if (this.state_.phase !== "live" || !this.socket_) return false;
    this.socket_.send(message);
    return true;
  }

  /** At once, unless something was sent since the last picture of the screen: then with the next, as it is by then. */
  private plan_flush(): void {
    if (this.holding_ || !this.flush()) return;
    this.holding_ = true;
    this.around_.next_frame(() => {
      this.holding_ = false;
      this.plan_flush();
    });
  }

  /** Whether there was something to send, and somebody to hear it. */
  private flush(): boolean {
    if (!this.scene_pending_ && !this.viewport_pending_ && !this.rest_pending_ && !this.effort_pending_) return false;
    if (this.state_.phase !== "live" || !this.socket_) return false; // said by `configured` once there is a connection
    this.input_seq_ += 1;
    this.socket_.send(
      encode_scene(this.input_seq_, {
        ...(this.scene_pending_ && this.scene_ ? { scene: this.scene_ } : {}),
        ...(this.viewport_pending_ ? { viewport: this.viewport_ } : {}),
        rest: this.rest_pending_,
        effort: this.effort_,
      }),
    );
    this.scene_pending_ = false;
    this.rest_pending_ = false;
    this.viewport_pending_ = false;
    this.effort_pending_ = false;
    return true;
  }

  private configured(config: Config): void {
    this.happened({ kind: "configured" });
    if (this.state_.phase !== "live") return;
    const seen = Number(config.inputSeq);
    this.take_role(config);
    // What this page wanted last and the worker has not seen (lost on the way, or a new session) wins.
    if (this.scene_ && (this.scene_pending_ || seen < this.input_seq_)) this.scene_pending_ = true;
    else if (config.scene) this.scene_ = config.scene;
    this.input_seq_ = Math.max(this.input_seq_, seen);
    // A worker begins with all of it; what was chosen while nobody heard it is said too.
    this.effort_pending_ = this.leads_ && (this.effort_pending_ || this.effort_ !== full_effort);
    if (!this.visible_) this.socket_?.send(encode_visibility(false));
    this.events_.config(this.scene_ ? { ...config, scene: this.scene_ } : config);
    this.plan_flush();
  }

  /** Whose the scene is from here on. */
  private take_role(config: Config): void {
    if (config.follower) {
      if (this.own_camera_) {
        // It comes back over a new connection, which does not know of the own camera yet.
        if (this.leads_ && this.scene_) this.own_pose_ = camera_of(this.scene_);
        this.socket_?.send(encode_own_camera(true));
      }
      this.leads_ = false;
      this.scene_pending_ = false;
      this.scene_ = null;
    } else if (!this.leads_) {
      this.leads_ = true;
      this.scene_ = null; // the presenter's is the newest
      const scene = config.scene;
      if (this.own_pose_ && scene) {
        this.scene_ = with_camera(scene, this.own_pose_);
        this.scene_pending_ = true;
      }
      this.own_pose_ = null;
    }
  }

  private heard_audience(audience: Audience): void {
    const me = audience.participants.find(({ id }) => id === audience.you);
    this.leads_ = audience.presenter === audience.you || (me?.ownCamera ?? false);
    if (!this.leads_) this.scene_pending_ = false;
    this.events_.audience(audience);
  }

  private received(data: Uint8Array): void {
    let message;
    try {
      message = decode_server_message(data);
    } catch {
      this.happened({ kind: "closed", code: 4400 });
      return;
    }
    const body = message.body;
    switch (body.case) {
      case "config":
        this.configured(body.value);
        break;
      case "frame":
        this.events_.frame(body.value);
        break;
      case "still":
        this.events_.still(body.value);
        break;
      case "slice":
        this.events_.slice(body.value);
        break;
      case "slicesStale":
        this.events_.slices_stale();
        break;
      case "state":
        this.events_.state(body.value);
        break;
      case "stats":
        this.events_.stats(body.value);
        break;
      case "audience":
        this.heard_audience(body.value);
        break;
      case "look":
        if (!body.value.scene || (this.own_camera_ && this.leads_)) break;
        this.scene_ = body.value.scene;
        this.events_.look(body.value.scene);
        break;
      case "depth":
        this.depths_.heard(body.value);
        break;
      case "problem":
        // Without a slot for it, it is not asked for again by itself.
        if (body.value.field === "own_camera" || body.value.field === "own_camera_taken") this.own_camera_ = false;
        this.events_.problem(body.value);
        break;
      case "fileProgress":
        this.events_.file_progress(body.value.done);
        break;
      case "filePart":
        this.events_.file_part(body.value);
        break;
      case "kernel":
        this.events_.kernel(body.value);
        break;
      default: // of a later protocol: nothing that this page must know
    }
  }

  private happened(event: ConnectionEvent): void {
    const before = this.state_;
    const step = advance(before, event, this.around_.chance());
    this.state_ = step.state;
    for (const effect of step.effects) this.carry_out(effect);
    if (step.state !== before) this.events_.connection(step.state);
  }

  private carry_out(effect: ConnectionEffect): void {
    switch (effect.kind) {
      case "ask_ticket":
        this.ask();
        break;
      case "open":
        this.open(effect.url);
        break;
      case "greet":
        this.viewport_pending_ = false; // the greeting says it
        this.socket_?.send(encode_hello(this.abilities_, this.around_.pixel_ratio(), this.viewport_));
        break;
      case "close":
        this.asking_?.abort();
        this.socket_number_ += 1; // whatever the old one still says is not heard
        this.socket_?.close();
        this.socket_ = null;
        this.depths_.lost();
        break;
      case "timer":
        this.disarm_();
        this.disarm_ = this.around_.after(effect.ms, () => this.happened({ kind: "timeout" }));
        break;
      case "disarm":
        this.disarm_();
        break;
    }
  }

  private ask(): void {
    this.asking_?.abort();
    const asking = new AbortController();
    this.asking_ = asking;
    this.around_.door(asking.signal).then(
      (answer) => {
        if (asking.signal.aborted) return;
        if (answer.ok) this.happened({ kind: "ticket", url: answer.url });
        else this.happened({ kind: "no_ticket", ...answer });
      },
      () => {
        if (!asking.signal.aborted) this.happened({ kind: "no_ticket", trouble: "unreachable", final: false });
      },
    );
  }

  private open(url: string): void {
    const number = ++this.socket_number_;
    const heard = (task: () => void) => {
      if (number === this.socket_number_) task();
    };
    this.socket_ = this.around_.open_socket(url, {
      opened: () => heard(() => this.happened({ kind: "opened" })),
      message: (data) => heard(() => this.received(data)),
      closed: (code) => heard(() => this.happened({ kind: "closed", code })),
    });
  }
}
