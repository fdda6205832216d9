import { batch, computed, effect, signal } from "@preact/signals";
import { add, scale, vec3, type Vec3 } from "../input/vec3";
import { inflate } from "./coding";
import { lookColours } from "./look_colours";
import { handleNear, isWhole, measureKinds, withHandle, withoutLast, type Held, type Measure } from "./measure";
import { firstOverlay, type OverlaySetting, type RememberedSlices } from "./memory";
import { wholeSlice, type Placing } from "./placing";
import { joined, mostPresented, type PresentedSlices, type Shown } from "./presented";
import type { TransferFunction } from "../protocol/gen/api/proto/scene_pb";
import { heldWithin, inSlice, pixelOf, planes, type Plane, type Stack } from "./stack";
import { SliceStore, type Coming, type StoreParts } from "./store";
import { bounded, firstWindow, tableOf, type Window } from "./window";

/** The tools for the left button or one finger. */
export const tools = ["window", "crosshair", ...measureKinds] as const;
export type Tool = (typeof tools)[number];

export type { Shown };

type Header = Parameters<typeof firstWindow>[0] & { readonly contentHash: string };
const middle = vec3(0, 0, 0);

/** The view to which a viewer returns after following someone else. */
interface OwnView {
  readonly remembered: RememberedSlices;
  readonly shown: Shown;
  readonly placings: Partial<Record<Plane, Placing>>;
}

/**
 * The slices that the server sends to this viewer. They are blank outside the clip unless they are `whole`. A viewer
 * who gets only the `shown` ones follows the presenter.
 */
export type Access = "none" | "shown" | "clipped" | "whole";

/** The state of the slice views. It persists while views open and close. */
export class Slices {
  readonly stacks = signal<ReadonlyMap<Plane, Stack>>(new Map());
  readonly access = signal<Access>("none");
  /** Whether there are slices to show. */
  readonly available = computed(() => this.access.value !== "none" && this.stacks.value.size > 0);
  /** Whether slices are shown. If not, only the 3D picture is shown. */
  readonly open = signal(false);
  readonly shown = signal<Shown>("four");
  /** Whether the page is too narrow for four views, so that it shows one at a time. */
  readonly narrow = signal(false);
  readonly crosshair = signal<Vec3>(middle);
  readonly window = signal<Window>({ centre: 0, width: 1 });
  readonly tool = signal<Tool>("window");
  readonly measures = signal<readonly Measure[]>([]);
  /** The handle of a measurement that follows the pointer or the crosshair. */
  readonly held = signal<Held | null>(null);
  readonly placings = signal<Partial<Record<Plane, Placing>>>({});
  /** Whether values are interpolated on the screen. Readings and measurements are always of the stored voxels. */
  readonly smooth = signal(true);
  /** Whether the colours of the look cover the grey, and how much. */
  readonly overlay = signal<OverlaySetting>(firstOverlay);
  /** The point under the pointer. */
  readonly pointed = signal<{ readonly plane: Plane; readonly place: Vec3 } | null>(null);
  /** Increases with every slice that arrives. */
  readonly received = signal(0);
  readonly damaged = signal(false);
  /** Whether someone else presents the slices, so that this viewer's own edits do not apply. */
  readonly following = signal(false);
  /** Whether a narrow page may choose which of the presented views it shows. */
  readonly choosable = computed(() => this.access.value !== "shown" || this.presentsFour.value);
  private readonly presentsFour = signal(false);

  readonly view = computed<Shown>(() => {
    if (!this.open.value || !this.available.value) return "picture";
    return this.narrow.value && this.shown.value === "four" ? "axial" : this.shown.value;
  });
  readonly pictureShown = computed(() => this.view.value === "picture" || this.view.value === "four");
  private readonly transfer = computed(() => this.look());
  private readonly colours = computed(() => (this.transfer.value ? lookColours(this.transfer.value) : null));
  /** The colour of every 16-bit value. */
  readonly table = computed(() => {
    const { shown, strength } = this.overlay.value;
    const colours = shown ? this.colours.value : null;
    return tableOf(this.window.value, colours && { colours, strength });
  });

  private readonly store: SliceStore;
  private readonly stopEffect: () => void;
  private first: Window = this.window.value;
  private knowsRange = true;
  private volume: string | null = null;
  /** This viewer's own view, while another is followed. */
  private own: OwnView | null = null;
  private presentedMeasures: readonly Measure[] = [];

  /**
   * Creates the state. `before` is restored if it belongs to the volume. `look` reads the signal of
   * the scene.
   */
  constructor(
    ask: StoreParts["ask"],
    private before: RememberedSlices | null = null,
    private readonly look: () => TransferFunction | null = () => null,
  ) {
    this.store = new SliceStore({
      ask,
      inflate,
      nextFrame: (task) => requestAnimationFrame(task),
      received: () => (this.received.value += 1),
      damaged: () => (this.damaged.value = true),
    });
    this.stopEffect = effect(() => {
      for (const plane of planes) {
        const stack = this.stacks.value.get(plane);
        const visible = stack && (this.view.value === "four" || this.view.value === plane);
        this.store.show(plane, visible ? pixelOf(stack, this.crosshair.value).slice : null);
      }
    });
  }

  /**
   * Takes over the stacks of a new connection. Everything is reset if they belong to another
   * volume.
   */
  configured(stacks: readonly Stack[], header: Header | undefined): void {
    this.damaged.value = false;
    // Without the volume's hash, the page requests its slices again after each reconnection.
    const volume = header && (header.contentHash || JSON.stringify(stacks));
    if (header && !header.contentHash) this.store.clear();
    if (header && volume !== undefined && volume !== this.volume) {
      this.volume = volume;
      this.store.clear();
      this.stacks.value = new Map(stacks.map((stack) => [stack.plane, stack]));
      this.first = firstWindow(header);
      this.knowsRange = header.windowWidth > 0 || header.percentiles.length > 0;
      this.reset();
      if (this.before?.volume === volume) this.restore(this.before);
      this.before = null;
    }
    this.store.connected();
  }

  allow(access: Access): void {
    if (access === this.access.value) return;
    if (access === "none") {
      this.unfollow();
      this.open.value = false;
    }
    this.store.clear();
    this.access.value = access;
    this.received.value += 1;
  }

  /** Discards slices of an earlier clip. */
  stale(): void {
    this.store.clear();
    this.received.value += 1;
  }

  receive(slice: Coming): void {
    void this.store.receive(slice);
  }

  stop(): void {
    this.stopEffect();
  }

  index(stack: Stack): number {
    return pixelOf(stack, this.crosshair.value).slice;
  }

  /** Returns the values of the slice at the crosshair, or null until they have arrived. */
  values(stack: Stack): Int16Array<ArrayBuffer> | null {
    return this.received.value >= 0 ? this.store.get({ plane: stack.plane, index: this.index(stack) }) : null;
  }

  valueAt(stack: Stack, place: Vec3): number | null {
    const { column, row } = pixelOf(stack, place);
    return this.values(stack)?.[row * stack.columns + column] ?? null;
  }

  scroll(stack: Stack, by: number): void {
    this.goTo(stack, this.index(stack) + by);
  }

  goTo(stack: Stack, index: number): void {
    this.held.value = null; // a measurement stays in its slice
    this.crosshair.value = inSlice(stack, this.crosshair.value, index);
  }

  pointAt(stack: Stack, place: Vec3): void {
    this.crosshair.value = heldWithin(stack, place);
  }

  /** Moves the crosshair within the slice by pixels. */
  step(stack: Stack, right: number, down: number): void {
    this.pointAt(stack, add(this.crosshair.value, add(scale(stack.right, right), scale(stack.down, down))));
  }

  placing(stack: Stack): Placing {
    return this.placings.value[stack.plane] ?? wholeSlice(stack);
  }

  place(stack: Stack, placing: Placing): void {
    this.placings.value = { ...this.placings.value, [stack.plane]: placing };
  }

  setWindow(window: Window): void {
    this.window.value = bounded(window);
  }

  /**
   * Grabs the handle within `reach` mm of a point, if there is one and no measurement is
   * unfinished.
   */
  hold(stack: Stack, place: Vec3, reach: number): boolean {
    const measures = this.measures.value;
    const last = measures.at(-1);
    if (last && !isWhole(last)) return false;
    this.held.value = handleNear(measures, stack, this.index(stack), place, reach);
    return this.held.value !== null;
  }

  moveHeld(stack: Stack, to: Vec3): void {
    const held = this.held.value;
    if (!held) return;
    const index = this.index(stack);
    this.measures.value = this.measures.value.map((one, i) =>
      i === held.measure && one.plane === stack.plane && one.slice === index
        ? withHandle(stack, one, held.handle, to)
        : one,
    );
  }

  removeLastMeasure(): void {
    this.held.value = null;
    this.measures.value = withoutLast(this.measures.value);
  }

  /** Shows only one of the four views, or all four again. */
  maximise(one: Exclude<Shown, "four">): void {
    this.shown.value = this.view.value === one ? "four" : one;
  }

  /** Returns what to restore after a reload, or null until there is a volume. */
  remembered(): RememberedSlices | null {
    if (this.own) return this.own.remembered;
    if (this.volume === null) return this.before;
    return {
      volume: this.volume,
      open: this.open.value,
      crosshair: this.crosshair.value,
      window: this.window.value,
      measures: this.measures.value,
      smooth: this.smooth.value,
      overlay: this.overlay.value,
    };
  }

  /** Returns what followers of this viewer see. */
  presented(): PresentedSlices {
    const { shown, strength } = this.overlay.value;
    return {
      view: this.open.value && this.available.value ? this.view.value : null,
      crosshair: this.crosshair.value,
      window: this.window.value,
      smooth: this.smooth.value,
      overlay: shown ? strength : 0,
      placings: this.placings.value,
    };
  }

  presentedMeasurements(): readonly Measure[] {
    return this.measures.value.filter(isWhole).slice(-mostPresented);
  }

  /** Shows what someone else presents, or this viewer's own view while they show no slices. */
  follow(presented: PresentedSlices): void {
    const { view } = presented;
    const remembered = this.remembered();
    if (view === null || !this.available.value || !remembered) {
      this.unfollow();
      this.beginWith(presented.window);
      return;
    }
    batch(() => {
      if (!this.following.value) {
        this.own = { remembered, shown: this.shown.value, placings: this.placings.value };
        this.following.value = true;
        this.held.value = null;
        this.measures.value = this.presentedMeasures;
      }
      this.open.value = true;
      this.presentsFour.value = view === "four";
      // A narrow page shows one view at a time, which its viewer chooses.
      if (view !== "four" || !this.narrow.value) this.shown.value = view;
      this.crosshair.value = presented.crosshair;
      this.setWindow(presented.window);
      this.smooth.value = presented.smooth;
      this.overlay.value = { shown: presented.overlay > 0, strength: presented.overlay || firstOverlay.strength };
      this.placings.value = presented.placings;
    });
  }

  /**
   * Starts with the presenter's window if this viewer, as a guest, does not know the range of the
   * scan's values.
   */
  private beginWith(window: Window): void {
    if (this.knowsRange || !this.available.value || window.width <= 0) return;
    const untouched = this.window.value.centre === this.first.centre && this.window.value.width === this.first.width;
    this.first = bounded(window);
    if (untouched) this.window.value = this.first;
  }

  followMeasurements(measures: readonly Measure[]): void {
    this.presentedMeasures = measures;
    if (this.following.value) this.measures.value = measures;
  }

  /** Returns to this viewer's own view. */
  unfollow(): void {
    const own = this.own;
    if (!own) return;
    batch(() => {
      this.own = null;
      this.following.value = false;
      this.restore(own.remembered);
      this.shown.value = own.shown;
      this.placings.value = own.placings;
    });
  }

  /** Continues with the view that was followed, because this viewer presents from now on. */
  takeOver(): void {
    const own = this.own;
    if (!own) return;
    this.own = null;
    this.measures.value = joined(own.remembered.measures, this.measures.value);
    this.following.value = false;
  }

  private restore({ open, crosshair, window, measures, smooth, overlay }: RememberedSlices): void {
    const axial = this.stacks.value.get("axial");
    if (axial) this.pointAt(axial, crosshair);
    this.setWindow(window);
    this.measures.value = measures;
    this.smooth.value = smooth;
    this.overlay.value = overlay;
    this.open.value = open;
  }

  /** Resets the zoom, the crosshair and the window. Measurements stay. */
  reset(): void {
    const axial = this.stacks.value.get("axial");
    this.crosshair.value = axial ? heldWithin(axial, middle) : middle;
    this.placings.value = {};
    this.window.value = this.first;
  }
}
