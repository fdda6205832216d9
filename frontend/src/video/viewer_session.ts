/* eslint max-lines: ["error", 513] */
import { computed, effect, signal } from "@preact/signals";
import type { Area, Point } from "../input/flat";
import { Collaboration } from "../live/collaboration";
import { OwnView } from "../live/own_view";
import { SharedMarks } from "../live/shared_marks";
import type { MarkLibrary } from "../marks/library";
import { Marks } from "../marks/marks";
import { marksFromText, marksToText } from "../marks/memory";
import { after } from "../live/paced";
import type { LookPictures, Place } from "../live/place";
import { roleOf } from "../live/role";
import type { Answered } from "../protocol/depth_queries";
import {
  encodeCurveQuery,
  encodeGoodViewsQuery,
  encodeKernelQuery,
  type KernelReport,
} from "../protocol/file_messages";
import type { Labels_Label as Label, SecondVolume } from "../protocol/gen/api/proto/stream_pb";
import { encodeHand } from "../protocol/mark_messages";
import { openBrowserSocket, probeServer } from "../protocol/browser_socket";
import { forVisit } from "../protocol/visit_socket";
import { firstState, isOver, type ConnectionState } from "../protocol/connection";
import {
  comingSlice,
  stacksOf,
  withinBounds,
  type Abilities,
  type Audience,
  type Codec,
  type Config,
  type Histogram,
  type Viewport,
  type Treatment,
  type VolumeHeader,
} from "../protocol/messages";
import { effortFrom, effortText, fullEffort, type Effort } from "../scene/effort";
import { slicesFromText, slicesToText } from "../slices/memory";
import { sourcesOf } from "../slices/sources";
import { Slices } from "../slices/model";
import type { Part } from "../scene/parts";
import { StreamClient } from "../protocol/stream_client";
import type { StreamEvents } from "../protocol/stream_events";
import { t } from "../texts";
import { tab } from "../storage";
import { AnswerWatch } from "./answer_watch";
import { CurveRequest } from "./curve_request";
import { ResizeDebouncer } from "./canvas_size";
import type { Painter } from "./painter";
import { pictureIn } from "./picture_in";
import { PhasePlayer } from "./phase_player";
import { PictureStore } from "./picture_store";
import { SceneEditor } from "./scene_editor";
import { GuidedCamera } from "./guided_camera";
import { problemText, sliceAccess } from "./session_reports";
import { marksKey, rememberView, rememberedView, slicesKey } from "./view_memory";

/** The browser's storage for the user's preferences. */
export type Preferences = Pick<Storage, "getItem" | "setItem">;

const effortKey = "diaphane.effort";
/** The longest side of a picture that the protocol allows. */
const longestSide = 4096;
const rememberedEveryMs = 250;

/** One viewer's connection to a data set, with its pictures and the editor of its scene. Independent of any view. */
export class ViewerSession {
  readonly connection = signal<ConnectionState>(firstState);
  readonly samplesPerSecond = signal(0);
  readonly device = signal("");
  /** The kernel that renders the picture, after a request. */
  readonly kernel = signal<KernelReport | null>(null);
  readonly volume = signal<VolumeHeader | null>(null);
  /** The scan that is shown over this one, if any. */
  readonly second = signal<SecondVolume | null>(null);
  /** How pictures differ from the stored scan. */
  readonly treatment = signal<Treatment | null>(null);
  /** The histogram of the volume, if the worker has sent it. */
  readonly histogram = signal<Histogram | null>(null);
  /** The labels of the scan, if it has any and this user may know them. */
  readonly labels = signal<readonly Label[]>([]);
  /** The participants, once they are known. */
  readonly audience = signal<Audience | null>(null);
  /** How much work a picture is worth. The setting belongs to the user, not to a scan. */
  readonly effort = signal<Effort>(fullEffort);
  /** The slice views next to the 3D picture. */
  readonly slices: Slices;
  /** What the participants show each other. */
  readonly collaboration: Collaboration;
  readonly ownView = new OwnView();
  readonly marks = new Marks();
  /** Sets of marks with changes that the server may not have yet. */
  unsavedSets: readonly string[] = [];
  /** Shared sets of the scan's owner that this viewer has hidden. */
  hiddenSets: readonly string[] = [];
  /** The marks that are saved with the scan, for users who may list them. */
  readonly library = signal<MarkLibrary | null>(null);
  /** The server's explanation of the last input that it rejected. */
  readonly problem = signal("");

  readonly pictures: PictureStore;
  readonly editor = new SceneEditor({
    leads: () => this.client.leads,
    canvasSize: () => this.canvasSize,
    send: (scene, rest) => {
      this.problem.value = "";
      this.client.setScene(scene, rest);
      this.rememberSoon();
    },
    rest: () => this.client.rest(),
    firstScene: (scene) => this.place.firstScene?.(scene) ?? null,
  });

  private readonly inputs = {
    sentInput: () => this.client.inputSeq,
    shownInput: () => this.pictures.picture.peek()?.inputSeq ?? 0,
    nowMs: () => performance.now(),
    after,
  };
  readonly answers = new AnswerWatch({ ...this.inputs, isOwed: () => this.client.isOwedPictures });

  /** Asks for the whole curve of the view, which has passes that were never shown. It replaces that of the pictures. */
  readonly curve = new CurveRequest(() => this.client.say(encodeCurveQuery()), this.inputs.nowMs);

  readonly guide = new GuidedCamera({
    editor: this.editor,
    leads: () => this.client.leads,
    canvasSize: () => this.canvasSize,
    presents: () => roleOf(this.audience.peek()).presents,
    loadStudy: () => this.place.loadTour?.() ?? Promise.resolve(null),
    isConnected: () => this.connection.peek().phase === "live",
    askForViews: () => this.client.say(encodeGoodViewsQuery()),
    ...this.inputs,
  });

  readonly phases = new PhasePlayer({
    editor: this.editor,
    leads: () => this.client.leads && roleOf(this.audience.peek()).presents,
    nextFrame: (task) => requestAnimationFrame(task),
    nowMs: this.inputs.nowMs,
  });

  private readonly sharedMarks: SharedMarks;
  private readonly stopWatching: () => void;
  private readonly client: StreamClient;
  private readonly resizeDebouncer: ResizeDebouncer;
  private currentSessionId: string | null;
  private canvasSize: Viewport;
  private followed = false;
  /** The size of the presenter's picture, once this viewer has followed. */
  private presentersSize: Viewport | null = null;
  private remembering: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly place: Place,
    private readonly painter: Painter,
    size: Viewport,
    private abilities: Abilities,
    private readonly preferences: Preferences,
  ) {
    const before = rememberedView(tab, place.key);
    this.slices = new Slices(
      (lacking, taken) => this.client.wantSlices(lacking, taken),
      slicesFromText(tab.getItem(slicesKey(place.key))),
      sourcesOf(() => this.editor.scene.value, this.labels, this.second),
    );
    this.currentSessionId = before.session_id;
    this.canvasSize = withinBounds(size, longestSide);
    this.painter.resize(this.canvasSize);
    const { nowMs } = this.inputs;
    this.client = new StreamClient(
      {
        ticketSource: place.ticketSource(before.session_id, (id) => (this.currentSessionId = id)),
        openSocket: place.openSocket ?? (place.isVisit ? forVisit(openBrowserSocket) : openBrowserSocket),
        nextFrame: (task) => requestAnimationFrame(task),
        after,
        chance: Math.random,
        nowMs,
        probe: probeServer,
        abilities: this.abilities,
        pixelRatio: () => devicePixelRatio,
      },
      this.events(),
      this.canvasSize,
    );
    this.collaboration = new Collaboration({
      say: (message) => this.client.say(message),
      after,
      slices: this.slices,
      audience: this.audience,
    });
    this.restoreMarks();
    this.pictures = new PictureStore(painter, {
      ack: (shown, times, queue) => this.client.ack(shown, times, queue),
      needKey: () => this.client.needKey(),
      giveUp: (codec) => this.giveUp(codec),
      damaged: () => (this.problem.value = t.viewer.tileDamaged),
      nowMs,
    });
    this.stopWatching = this.watchPictures();
    this.sharedMarks = this.shareMarks();
    this.resizeDebouncer = new ResizeDebouncer(this.canvasSize, (size) => this.resized(size), { nowMs, after });
    this.editor.begun.value = before.begun;
    const effort = effortFrom(preferences.getItem(effortKey));
    if (effortText(effort) !== effortText(fullEffort)) this.client.setEffort((this.effort.value = effort));
    if (before.scene) {
      this.client.remember(before.scene, before.input_seq);
      this.editor.scene.value = before.scene;
      this.editor.steps.value = before.steps;
    }
  }

  start(): void {
    this.client.start();
    this.answers.start();
  }

  /** Releases the worker's slot when the user leaves the page, and remembers the view. */
  leave(): void {
    clearTimeout(this.remembering);
    const id = this.currentSessionId;
    this.currentSessionId = null;
    this.remember();
    this.stopWatching();
    this.answers.stop();
    this.guide.close();
    this.phases.close();
    this.client.stop();
    this.resizeDebouncer.stop();
    this.collaboration.stop();
    this.sharedMarks.stop();
    this.slices.stop();
    this.pictures.close();
    this.place.leave(id);
  }

  get dataSetId(): string | null {
    return this.place.data_set_id;
  }

  /** Returns the pictures of the looks, or null if this person gets none. */
  get lookPictures(): LookPictures | null {
    return this.place.lookPictures;
  }

  get sessionId(): string | null {
    return this.currentSessionId;
  }

  /** Returns the size of the canvas in device pixels. */
  get viewport(): Viewport {
    return this.canvasSize;
  }

  get newestInput(): number {
    return this.client.inputSeq;
  }

  handOver(to: string): void {
    this.client.handOver(to);
  }

  /** Sets whether guests may see the slices, limited to the clip. */
  setGuestSlices(on: boolean): void {
    this.client.setGuestSlices(on);
  }

  /** Raises or lowers this viewer's hand, or lowers that of the participant with the ID `of`. */
  raiseHand(on: boolean, of = ""): void {
    this.client.say(encodeHand(on, of));
  }

  useFreeCamera(on: boolean): void {
    this.ownView.asked(on);
    this.client.useFreeCamera(on);
  }

  /**
   * Asks for the surface at a point of the picture. `x` and `y` range from 0 to 1, from the top
   * left.
   */
  depthAt(x: number, y: number): Promise<Answered> {
    return this.client.depthAt(x, y);
  }

  /**
   * Asks which kernel renders the picture. The answer arrives in `kernel` with the next picture.
   */
  askForKernel(): void {
    this.client.say(encodeKernelQuery());
  }

  /** Moves this viewer's pointer. `at` is in CSS pixels from the top left of the canvas, whose size is `area`. */
  pointAt(at: Point | null, area: Area): void {
    const picture = this.pictures.picture.value;
    const place = picture && pictureIn(area, picture, !this.client.leads);
    const x = at && place ? (at.x - place.x) / place.width : -1;
    const y = at && place ? (at.y - place.y) / place.height : -1;
    this.collaboration.point(x >= 0 && x <= 1 && y >= 0 && y <= 1 ? { x, y } : null);
  }

  wake(): void {
    this.client.wake();
  }

  checkNetwork(): void {
    this.client.checkNetwork();
  }

  setVisible(visible: boolean): void {
    this.client.setVisible(visible);
    if (visible) this.client.wake();
  }

  /** Requests the picture again, as a new viewer would, because the shown one is lost. */
  showAnew(): void {
    this.pictures.lossless.value = null;
    this.client.greetAgain(this.abilities);
  }

  /** Sets the size of the canvas. The canvas keeps its pixels until the size has settled. */
  resize(size: Viewport): void {
    this.resizeDebouncer.changed(withinBounds(size, longestSide));
  }

  /**
   * Sets the effort, which is not an undo step, because the converged picture stays the same.
   * Stored once the control is released.
   */
  setEffort(effort: Effort, held = false): void {
    this.effort.value = effort;
    this.client.setEffort(effort);
    this.rememberSoon();
    if (!held) this.keepEffort();
  }

  keepEffort(): void {
    this.preferences.setItem(effortKey, effortText(this.effort.value));
  }

  /** Resets one part of the scene, and with the lens also the effort. */
  reset(part: Part): void {
    this.editor.reset(part);
    if (part === "lens") this.setEffort(fullEffort);
    this.editor.rest();
  }

  /** Stores the view immediately, because the page may be about to close. */
  remember(): void {
    rememberView(tab, this.place.key, {
      session_id: this.currentSessionId,
      scene: this.editor.scene.value,
      begun: this.editor.begun.value,
      input_seq: this.client.inputSeq,
      steps: this.editor.steps.value,
    });
    const slices = this.slices.remembered();
    if (slices) tab.setItem(slicesKey(this.place.key), slicesToText(slices));
    const { items, shown } = this.marks;
    const marks = { items: items.value, shown: shown.value, unsaved: this.unsavedSets, hidden: this.hiddenSets };
    tab.setItem(marksKey(this.place.key), marksToText(marks));
  }

  /** Notes what each new picture on the screen means to a follower. */
  private watchPictures(): () => void {
    return effect(() => {
      const shown = this.pictures.picture.value;
      if (!shown) return;
      this.ownView.pictureCame();
      if (this.followed) this.presentersSize = shown;
    });
  }

  private shareMarks(): SharedMarks {
    return new SharedMarks({
      say: (message) => this.client.say(message),
      after,
      marks: this.marks,
      audience: this.audience,
      view: computed(() => this.pictures.picture.value?.epoch ?? null),
    });
  }

  private restoreMarks(): void {
    const before = marksFromText(tab.getItem(marksKey(this.place.key)));
    if (!before) return;
    this.marks.replace(before.items);
    this.marks.shown.value = before.shown;
    this.unsavedSets = before.unsaved;
    this.hiddenSets = before.hidden;
  }

  /** Handles the messages of the server. */
  private events(): StreamEvents {
    return {
      connection: (state) => {
        // Drops the message of the last connection. On a live one, a configuration also follows the
        // message that the own view was closed, which must stay.
        if (state.phase === "live" && this.connection.value.phase !== "live") this.problem.value = "";
        this.connection.value = state;
        if (isOver(state)) this.slices.allow("none"); // nothing of the scan stays on the screen
      },
      config: (config) => this.configured(config),
      frame: (frame) => this.pictures.receive(frame),
      slice: (slice) => {
        const coming = comingSlice(slice);
        if (coming) this.slices.receive(coming);
      },
      slicesStale: () => this.slices.stale(),
      still: (still) => this.pictures.receiveStill(still),
      state: (state) => this.pictures.setConverged(state.converged ? Number(state.epoch) : null),
      audience: (audience) => {
        this.audience.value = audience;
        const { freeCamera, presents } = roleOf(audience);
        this.ownView.audienceChanged(freeCamera);
        if (presents) this.ownView.refused(); // the server drops the request of a new presenter
        this.slices.allow(sliceAccess[audience.slices]);
        this.collaboration.audienceChanged(audience);
        this.sharedMarks.audienceChanged(audience);
        this.painter.fitToWindow(!this.client.leads);
        if (!this.client.leads) this.follows();
        else if (this.followed) this.tookOver();
        this.followed = !this.client.leads;
      },
      look: (scene) => this.editor.replace(scene),
      stats: (stats) => (this.samplesPerSecond.value = stats.samplesPerSecond),
      problem: ({ field, message, inputSeq }) => {
        if (inputSeq > 0n) this.phases.pause(); // a phase that cannot be shown would be refused again and again
        this.answers.refuse(Number(inputSeq));
        this.pictures.beginWith(0); // the first input may be the refused one
        if (field === "good_views") this.guide.tour.receive(null);
        if (field.startsWith("own_camera")) this.ownView.refused();
        // A tour reports its own failure, and a refused pointer or mark needs no message: the presenter has turned off those of guests.
        if (!["pointer", "marks", "good_views"].includes(field)) this.problem.value = problemText(field, message);
      },
      fileProgress: () => undefined,
      filePart: () => undefined,
      kernel: (report) => (this.kernel.value = report),
      errorCurve: (curve) => {
        this.pictures.takeCurve(curve);
        this.curve.answered();
      },
      shared: (shared) => {
        this.collaboration.receive(shared);
        this.sharedMarks.receive(shared);
      },
      volumePhases: (phases) => (this.phases.loaded.value = phases),
      goodViews: (views) => this.guide.tour.receive(views),
      labels: ({ labels }) => (this.labels.value = labels),
      markSight: (sight) => this.sharedMarks.receiveSight(sight),
    };
  }

  private follows(): void {
    this.editor.forgetSteps();
    this.pictures.beginWith(0); // the presenter counts their own inputs
  }

  /** Reframes the picture, which someone else framed until now for a window of another shape. */
  private tookOver(): void {
    const before = this.presentersSize; // not that of the last picture, which may be of an own view
    const firstInput = this.client.inputSeq + 1; // read first, because the editor may send this input at once
    if (before && this.editor.resized(before, this.canvasSize)) this.pictures.beginWith(firstInput);
  }

  private resized(size: Viewport): void {
    const before = this.canvasSize;
    this.pictures.resize(size);
    this.client.setViewport(size);
    this.guide.during(() => {
      this.canvasSize = size;
      this.editor.resized(before, size);
    });
  }

  private configured(config: Config): void {
    this.pictures.reset();
    this.device.value = config.device;
    this.kernel.value = null;
    this.volume.value = config.volume ?? null;
    this.second.value = config.second ?? null;
    this.phases.configured(config.volume?.phases ?? []);
    this.treatment.value = config.treatment ?? null;
    this.slices.configured(stacksOf(config.sliceStacks), config.volume);
    this.histogram.value = config.histogram ?? null;
    this.labels.value = []; // sent next, if there are any
    this.collaboration.connected();
    this.sharedMarks.connected();
    const isFirst = !config.follower && this.presentersSize === null;
    const untouched = isFirst && config.inputSeq === 0n && this.client.inputSeq === 0;
    const firstInput = this.client.inputSeq + 1; // read first, because the editor may send this input at once
    const isReframed = this.editor.configured(config, untouched);
    // The worker has begun to render the volume's own view, which is too large for a narrow window.
    if (isReframed) this.pictures.beginWith(firstInput);
    this.rememberSoon();
  }

  /** Falls back to the next codec. The last one is kept even if it fails. */
  private giveUp(codec: Codec): void {
    const codecs = this.abilities.codecs.filter((one) => one !== codec);
    if (codecs.length === 0) return;
    this.abilities = { ...this.abilities, codecs };
    this.client.greetAgain(this.abilities);
  }

  private rememberSoon(): void {
    this.remembering ??= setTimeout(() => {
      this.remembering = undefined;
      this.remember();
    }, rememberedEveryMs);
  }
}
