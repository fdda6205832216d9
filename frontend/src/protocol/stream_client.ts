import type { CameraPose } from "../input/camera";
import {
  advance,
  firstState,
  type ConnectionEffect,
  type ConnectionEvent,
  type ConnectionState,
  type Trouble,
} from "./connection";
import { DepthQueries, type Answered } from "./depth_queries";
import {
  decodeServerMessage,
  encodeAck,
  encodeHandover,
  encodeHello,
  encodeNeedKey,
  encodeGuestSlices,
  encodeFreeCamera,
  encodeScene,
  encodeSlices,
  encodeVisibility,
  cameraOf,
  withCamera,
  type Abilities,
  type Audience,
  type Config,
  type FrameTimes,
  type Scene,
  type Viewport,
} from "./messages";
import { encodeFile, encodeFileTaken, type FileOrder, type FilePart } from "./file_messages";
import type { StreamEvents } from "./stream_events";
import { SilenceWatch, type SilenceDependencies } from "./silence_watch";
import { fullEffort, type Effort } from "../scene/effort";
import type { WantedSlice } from "../slices/store";

/** Returns a worker's one-time URL, or why there is none. Every connection attempt calls it again. */
export type TicketSource = (
  signal: AbortSignal,
) => Promise<
  | { readonly ok: true; readonly url: string }
  | { readonly ok: false; readonly trouble: Trouble; readonly final: boolean; readonly retryAfterMs?: number }
>;

/** The part of a WebSocket that is used, so that tests can replace it. */
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

export interface StreamDependencies extends Pick<SilenceDependencies, "nowMs" | "probe"> {
  readonly ticketSource: TicketSource;
  readonly openSocket: OpenSocket;
  /** Runs `task` once before the next screen refresh. */
  readonly nextFrame: (task: () => void) => void;
  readonly after: (ms: number, task: () => void) => () => void;
  readonly chance: () => number;
  readonly abilities: Abilities;
  readonly pixelRatio: () => number;
}

/**
 * Implements api/proto/stream.proto. Holds the scene that the user wants. Scenes are absolute and the newest one wins.
 * Each is sent immediately, but at most once per screen refresh, and again to a worker that does not have it.
 */
export class StreamClient {
  private state: ConnectionState = firstState;
  private socket: Socket | null = null;
  private socketNumber = 0;
  private disarm: () => void = () => undefined;
  private asking: AbortController | null = null;

  private scene: Scene | null = null;
  private viewport: Viewport;
  private abilities: Abilities;
  private visible = true;
  private lastInputSeq = 0;
  private scenePending = false;
  private restPending = false;
  private viewportPending = false;
  private effort = fullEffort;
  private effortPending = false;
  private holding = false;
  /** Whether this page controls the scene: it presents, or it has a free camera. */
  private leading = true;
  /** Whether this page has changed the scene since it took control. A scene of the last presenter is older. */
  private edited = false;
  private freeCamera = false;
  private readonly depths: DepthQueries;
  private readonly silence: SilenceWatch;
  /** The picture is not finished, so messages are due. */
  private unfinished = false;
  /** Where the free camera was before the connection was lost. */
  private ownPose: CameraPose | null = null;

  constructor(
    private readonly dependencies: StreamDependencies,
    private readonly events: StreamEvents,
    viewport: Viewport,
  ) {
    this.viewport = viewport;
    this.abilities = dependencies.abilities;
    this.depths = new DepthQueries({ send: (message) => this.say(message), after: dependencies.after });
    this.silence = new SilenceWatch({ ...dependencies, lost: () => this.happened({ kind: "lost" }) });
  }

  get connection(): ConnectionState {
    return this.state;
  }

  /** The number of the newest input. */
  get inputSeq(): number {
    return this.lastInputSeq;
  }

  start(): void {
    this.happened({ kind: "start" });
  }

  stop(): void {
    this.happened({ kind: "stop" });
  }

  /** Ends the current wait, because the network is back or the page is visible again. */
  wake(): void {
    this.happened({ kind: "wake" });
  }

  /** The browser has reported that it has no network. */
  checkNetwork(): void {
    if (this.state.phase === "live") this.silence.check();
  }

  /** The last request of an earlier visit, sent only to a worker that has not received it. Call before `start`. */
  remember(scene: Scene, inputSeq: number): void {
    this.scene = scene;
    this.lastInputSeq = inputSeq;
  }

  get leads(): boolean {
    return this.leading;
  }

  handOver(to: string): void {
    if (this.state.phase === "live") this.socket?.send(encodeHandover(to));
  }

  /** Switches between a free camera and the presenter's. The choice survives a reconnection. */
  useFreeCamera(on: boolean): void {
    this.freeCamera = on;
    this.ownPose = null;
    if (this.state.phase === "live") this.socket?.send(encodeFreeCamera(on));
  }

  setGuestSlices(on: boolean): void {
    if (this.state.phase === "live") this.socket?.send(encodeGuestSlices(on));
  }

  setScene(scene: Scene, rest = false): void {
    if (!this.leading) return;
    this.edited = true;
    this.scene = scene;
    this.scenePending = true;
    this.restPending = rest;
    this.planFlush();
  }

  /** Tells the worker that the gesture has ended, so that it can render the full picture immediately. */
  rest(): void {
    if (!this.leading) return;
    this.restPending = true;
    this.planFlush();
  }

  /** Sent to every new worker. */
  setEffort(effort: Effort): void {
    this.effort = effort;
    if (!this.leading) return;
    this.effortPending = true;
    this.planFlush();
  }

  setViewport(viewport: Viewport): void {
    if (viewport.width === this.viewport.width && viewport.height === this.viewport.height) return;
    this.viewport = viewport;
    this.viewportPending = true;
    this.planFlush();
  }

  /** Whether the renderer sends this viewer a picture for each input. */
  get isOwedPictures(): boolean {
    return this.leads && this.visible && this.state.phase === "live";
  }

  setVisible(visible: boolean): void {
    if (visible === this.visible) return;
    this.visible = visible;
    if (this.state.phase === "live") this.socket?.send(encodeVisibility(visible));
    this.expectMessages();
  }

  /** Reconnects and greets the worker with other abilities. The scene stays. */
  greetAgain(abilities: Abilities): void {
    this.abilities = abilities;
    this.happened({ kind: "again" });
  }

  /** Requests the missing slices. After a reconnection, the caller requests them again. */
  wantSlices(lacking: readonly WantedSlice[], taken: bigint): void {
    if (this.state.phase === "live") this.socket?.send(encodeSlices(lacking, taken));
  }

  /** Asks for the distance of the surface at a point of the picture. */
  depthAt(x: number, y: number): Promise<Answered> {
    return this.depths.ask(x, y);
  }

  /** Orders a file, one at a time. The order ends with the connection. */
  askForFile(order: FileOrder): void {
    for (const message of encodeFile(order)) this.say(message);
  }

  fileTaken({ seq }: FilePart): void {
    this.say(encodeFileTaken(seq));
  }

  needKey(): void {
    if (this.state.phase === "live") this.socket?.send(encodeNeedKey());
  }

  /** Required for each frame and still, shown or not, because the server keeps about two in flight. */
  ack(frame: { readonly seq: bigint; readonly epoch: bigint }, times: FrameTimes, queue: number): void {
    if (this.state.phase === "live") this.socket?.send(encodeAck(frame.seq, frame.epoch, times, queue));
    if (times.presentedMs !== undefined) this.happened({ kind: "picture" });
  }

  /** Sends a message now. Returns false without a connection. */
  say(message: Uint8Array<ArrayBuffer>): boolean {
    if (this.state.phase !== "live" || !this.socket) return false;
    this.socket.send(message);
    return true;
  }

  /**
   * Sends immediately, unless something was sent since the last screen refresh. In that case, sends the latest state at
   * the next one.
   */
  private planFlush(): void {
    if (this.holding || !this.flush()) return;
    this.holding = true;
    this.dependencies.nextFrame(() => {
      this.holding = false;
      this.planFlush();
    });
  }

  /** Returns whether there was something to send and a connection to send it on. */
  private flush(): boolean {
    if (!this.scenePending && !this.viewportPending && !this.restPending && !this.effortPending) return false;
    if (this.state.phase !== "live" || !this.socket) return false; // `configured` sends it once there is a connection
    this.lastInputSeq += 1;
    this.socket.send(
      encodeScene(this.lastInputSeq, {
        ...(this.scenePending && this.scene ? { scene: this.scene } : {}),
        ...(this.viewportPending ? { viewport: this.viewport } : {}),
        rest: this.restPending,
        effort: this.effort,
      }),
    );
    this.scenePending = false;
    this.restPending = false;
    this.viewportPending = false;
    this.effortPending = false;
    this.expectMessages(true);
    return true;
  }

  /** A hidden page gets nothing, and neither does one whose picture is finished. */
  private expectMessages(unfinished = this.unfinished): void {
    this.unfinished = unfinished;
    this.silence.expect(this.state.phase === "live" && this.visible && this.unfinished);
  }

  private configured(config: Config): void {
    this.happened({ kind: "configured" });
    if (this.state.phase !== "live") return;
    const seen = Number(config.inputSeq);
    this.takeRole(config);
    // The last scene of this page wins if the worker has not seen it, because it was lost in transit or the session is
    // new.
    if (this.scene && (this.scenePending || seen < this.lastInputSeq)) this.scenePending = true;
    else if (config.scene) this.scene = config.scene;
    this.lastInputSeq = Math.max(this.lastInputSeq, seen);
    // A worker starts with the full effort, so a choice made while disconnected must be sent.
    this.effortPending = this.leading && (this.effortPending || this.effort !== fullEffort);
    if (!this.visible) this.socket?.send(encodeVisibility(false));
    this.expectMessages(true);
    this.events.config(this.scene ? { ...config, scene: this.scene } : config);
    this.planFlush();
  }

  /** Takes over whether this page controls the scene from now on. */
  private takeRole(config: Config): void {
    if (config.follower) {
      if (this.freeCamera) {
        // It returns over a new connection, which does not know of the free camera yet.
        if (this.leading && this.scene) this.ownPose = cameraOf(this.scene);
        this.socket?.send(encodeFreeCamera(true));
      }
      this.leading = this.edited = this.scenePending = false;
      this.scene = null;
    } else if (!this.leading) {
      this.leading = true;
      this.scene = null; // the presenter's scene is the newest
      const scene = config.scene;
      if (this.ownPose && scene) {
        this.scene = withCamera(scene, this.ownPose);
        this.scenePending = true;
      }
      this.ownPose = null;
    }
  }

  private receiveAudience(audience: Audience): void {
    const me = audience.participants.find(({ id }) => id === audience.you);
    this.leading = audience.presenter === audience.you || (me?.freeCamera ?? false);
    if (!this.leading) this.scenePending = this.edited = false;
    this.events.audience(audience);
  }

  private received(data: Uint8Array): void {
    let body;
    try {
      ({ body } = decodeServerMessage(data));
    } catch {
      this.happened({ kind: "closed", code: 4400 });
      return;
    }
    switch (body.case) {
      case "config":
        this.configured(body.value);
        break;
      case "frame":
      case "still":
      case "slice":
      case "stats":
      case "filePart":
      case "kernel":
      case "errorCurve":
      case "shared":
      case "markSight":
      case "labels":
      case "goodViews":
      case "volumePhases":
        this.events[body.case](body.value as never); // the value belongs to the case
        break;
      case "slicesStale":
        this.events.slicesStale();
        break;
      case "state":
        this.expectMessages(!body.value.converged);
        this.events.state(body.value);
        break;
      case "audience":
        this.receiveAudience(body.value);
        break;
      case "look":
        if (!body.value.scene || (this.leading && (this.freeCamera || this.edited))) break;
        this.events.look((this.scene = body.value.scene));
        break;
      case "depth":
        this.depths.receive(body.value);
        break;
      case "problem":
        // If no slot is free for it, it is not requested again automatically.
        if (body.value.field === "own_camera" || body.value.field === "own_camera_taken") this.freeCamera = false;
        this.events.problem(body.value);
        break;
      case "fileProgress":
        this.events.fileProgress(body.value.done);
        break;
      default: // of a later protocol: nothing that this page must know
    }
  }

  private happened(event: ConnectionEvent): void {
    const before = this.state;
    const step = advance(before, event, this.dependencies.chance());
    this.state = step.state;
    for (const effect of step.effects) this.carryOut(effect);
    if (step.state === before) return;
    this.expectMessages();
    this.events.connection(step.state);
  }

  private carryOut(effect: ConnectionEffect): void {
    switch (effect.kind) {
      case "ask_ticket":
        this.ask();
        break;
      case "open":
        this.open(effect.url);
        break;
      case "greet":
        this.viewportPending = false; // part of the greeting
        this.socket?.send(encodeHello(this.abilities, this.dependencies.pixelRatio(), this.viewport));
        break;
      case "close":
        this.asking?.abort();
        this.socketNumber += 1; // further messages of the old socket are ignored
        this.socket?.close();
        this.socket = null;
        this.depths.lost();
        break;
      case "timer":
        this.disarm();
        this.disarm = this.dependencies.after(effect.ms, () => this.happened({ kind: "timeout" }));
        break;
      case "disarm":
        this.disarm();
        break;
    }
  }

  private ask(): void {
    this.asking?.abort();
    const asking = new AbortController();
    this.asking = asking;
    this.dependencies.ticketSource(asking.signal).then(
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
    const number = ++this.socketNumber;
    const ifCurrent = (task: () => void) => {
      if (number === this.socketNumber) task();
    };
    this.socket = this.dependencies.openSocket(url, {
      opened: () => ifCurrent(() => this.happened({ kind: "opened" })),
      message: (data) =>
        ifCurrent(() => {
          this.silence.messageReceived();
          this.received(data);
        }),
      closed: (code) => ifCurrent(() => this.happened({ kind: "closed", code })),
    });
  }
}
