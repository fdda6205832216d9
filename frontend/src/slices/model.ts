import { batch, computed, effect, signal } from "@preact/signals";
import { add, scale, vec3, type Vec3 } from "../input/vec3";
import { clamp } from "../scene/numbers";
import { inflate } from "./coding";
import { CurveView, noCurve, type CurvedSlice } from "./curve_view";
import { firstLabels, labelTable, showsLabels, type LabelSetting } from "./label_overlay";
import { lookColours } from "./look_colours";
import {
  handleNear,
  isInSlice,
  isWhole,
  withCorner,
  withHandle,
  withLastPoint,
  withoutLast,
  withPoint,
  type Held,
  type Measure,
  type MeasureKind,
} from "./measure";
import { firstOverlay, type OverlaySetting, type RememberedSlices } from "./memory";
import { noSlab, obliqueStack, slabLimits, straightTilt, turned, type Slab, type Tilt } from "./oblique";
import { carried, wholeSlice, type Placing } from "./placing";
import { joined, mostPresented, type OwnView, type PresentedSlices, type Shown } from "./presented";
import type { Labels_Label as Label } from "../protocol/gen/api/proto/stream_pb";
import { heldWithin, inSlice, offsetOf, pixelOf, planes, type Plane, type Stack } from "./stack";
import { SecondOverlay, type SecondValue } from "./second_overlay";
import { noSources, type SliceSources } from "./sources";
import { SliceStore, type Coming, type StoreParts, type Voxels } from "./store";
import type { Access, Tool } from "./tools";
import { bounded, firstWindow, tableOf, type ScanHeader, type Window } from "./window";

export type { Access, Shown, Tool };

const middle = vec3(0, 0, 0);

/** The state of the slice views. It persists while views open and close. */
export class Slices {
  /** The stacks of the server, along the patient's axes. */
  readonly straight = signal<ReadonlyMap<Plane, Stack>>(new Map());
  /** The directions of tilted planes, or null while they lie along the patient's axes. */
  readonly tilt = signal<Tilt | null>(null);
  readonly slab = signal<Slab>(noSlab);
  /** The stacks that are shown. */
  readonly stacks = computed(() => this.shownStacks());
  readonly access = signal<Access>("none");
  /** Whether there are slices to show. */
  readonly available = computed(() => this.access.value !== "none" && this.straight.value.size > 0);
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
  /** Whether the colours of the labels cover the grey, and how much. */
  readonly labels = signal<LabelSetting>(firstLabels);
  /** The number of the label that is chosen in the list, or was pressed in a slice. */
  readonly chosenLabel = signal<number | null>(null);
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
  private readonly transfer = computed(() => this.sources.look());
  private readonly colours = computed(() => (this.transfer.value ? lookColours(this.transfer.value) : null));
  /** The colour of every 16-bit value. */
  readonly table = computed(() => {
    const { shown, strength } = this.overlay.value;
    const colours = shown ? this.colours.value : null;
    return tableOf(this.window.value, colours && { colours, strength });
  });

  private readonly labelList = computed(() => this.sources.labels());
  private readonly labelLooks = computed(() => this.sources.looks());
  /** Whether the scan has labels, and whether slices show their colours. */
  readonly hasLabels = computed(() => this.labelList.value.length > 0);
  readonly labelsShown = computed(() => showsLabels(this.labels.value, this.labelList.value));
  /** The colour of each label's place, or null while labels are not shown. */
  readonly labelTable = computed(() =>
    this.labelsShown.value ? labelTable(this.labelList.value, this.labelLooks.value, this.labels.value.strength) : null,
  );

  /** The second scan of the session over the first. */
  readonly second: SecondOverlay;
  /** The curve that this viewer draws, which is not presented. */
  readonly curve = new CurveView({ slab: this.slab, spacing: () => this.spacing });
  /** Whether the slice along the curve is shown. */
  readonly curveShown = computed(
    () => this.canDraw() && (this.tool.value === "curve" || this.curve.path.value !== null),
  );

  private readonly store: SliceStore;
  private readonly stopEffect: () => void;
  private first: Window = this.window.value;
  private knowsRange = true;
  /** The smallest distance of stored voxels in mm. */
  private spacing = 1;
  private obliqueId = 0;
  private volume: string | null = null;
  /** This viewer's own view, while another is followed. */
  private own: OwnView | null = null;
  private presentedMeasures: readonly Measure[] = [];

  /**
   * Creates the state. `before` is restored if it belongs to the volume.
   */
  constructor(
    ask: StoreParts["ask"],
    private before: RememberedSlices | null = null,
    private readonly sources: SliceSources = noSources,
  ) {
    this.second = new SecondOverlay(sources.second);
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
        this.store.show(plane, visible ? pixelOf(stack, this.crosshair.value).slice : null, stack);
      }
      this.store.showCurved(this.curveShown.value ? this.curve.slice.value : null);
    });
  }

  /**
   * Takes over the stacks of a new connection. Everything is reset if they belong to another
   * volume.
   */
  configured(stacks: readonly Stack[], header: ScanHeader | undefined): void {
    this.damaged.value = false;
    // Without the volume's hash, the page requests its slices again after each reconnection.
    const volume = header && (header.contentHash || JSON.stringify(stacks));
    if (header && !header.contentHash) this.store.clear();
    if (header && volume !== undefined && volume !== this.volume) {
      this.volume = volume;
      this.store.clear();
      this.straight.value = new Map(stacks.map((stack) => [stack.plane, stack]));
      this.spacing = Math.min(...header.spacing);
      this.first = firstWindow(header);
      this.knowsRange = header.windowWidth > 0 || header.percentiles.length > 0;
      this.reset();
      this.curve.restore(noCurve);
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
    return this.voxels(stack)?.values ?? null;
  }

  private voxels(stack: Stack): Voxels | null {
    const { plane, oblique } = stack;
    return this.received.value >= 0 ? this.store.get({ plane, index: this.index(stack), oblique: oblique?.id }) : null;
  }

  /** Returns what is drawn: the slice, or while it is turned and has not arrived, the one before. */
  drawnVoxels(stack: Stack): Voxels | null {
    const before = () => this.store.newestOblique(stack.plane, stack.columns * stack.rows);
    return this.voxels(stack) ?? (stack.oblique ? before() : null);
  }

  /** Curves belong to viewers who choose their own slices. */
  private canDraw(): boolean {
    return this.access.value !== "shown" && !this.following.value && this.view.value !== "picture";
  }

  /** Returns the values of the slice along the curve. While it has not arrived, `drawn` returns the one before. */
  curveVoxels({ id, grid }: CurvedSlice, drawn = false): Voxels | null {
    const exact = this.received.value >= 0 ? this.store.get({ plane: "curve", index: 0, oblique: id }) : null;
    return exact ?? (drawn ? this.store.newestOblique("curve", grid.columns * grid.rows) : null);
  }

  /** Returns the label at a place in the list of labels, from 1. */
  labelOf(place: number | undefined): Label | null {
    return this.labelList.value[(place ?? 0) - 1] ?? null;
  }

  /** Returns the label at a point of the shown slice, also while its colour is not shown. */
  labelAt(stack: Stack, place: Vec3): Label | null {
    return this.labelOf(this.voxels(stack)?.labels?.[offsetOf(stack, place)]);
  }

  /** Returns the value of the second scan at a point of the shown slice, or null outside of that scan. */
  secondAt(stack: Stack, place: Vec3): SecondValue | null {
    return this.second.valueOf(this.voxels(stack)?.second?.[offsetOf(stack, place)]);
  }

  valueAt(stack: Stack, place: Vec3): number | null {
    return this.values(stack)?.[offsetOf(stack, place)] ?? null;
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

  /** Turns the other two planes about the crosshair, clockwise in the view of `plane`. */
  turn(plane: Plane, degrees: number): void {
    const tilt = this.tilt.value ?? straightTilt(this.straight.value);
    if (tilt) this.reshape(() => (this.tilt.value = turned(tilt, plane, (Math.PI / 180) * degrees)));
  }

  straighten(): void {
    this.reshape(() => (this.tilt.value = null));
  }

  setSlab({ mm, projection }: Slab): void {
    this.reshape(() => (this.slab.value = { mm: clamp(mm, slabLimits.low, slabLimits.high), projection }));
  }

  /** Changes the stacks, and keeps what the views show in its place. */
  private reshape(change: () => void): void {
    const before = this.stacks.value;
    batch(() => {
      this.held.value = null;
      change();
      const placings = Object.entries(this.placings.value) as [Plane, Placing][];
      this.placings.value = Object.fromEntries(
        placings.map(([plane, placing]) => {
          const [from, to] = [before.get(plane), this.stacks.value.get(plane)];
          return [plane, from && to ? carried(placing, from, to) : placing];
        }),
      );
    });
  }

  private shownStacks(): ReadonlyMap<Plane, Stack> {
    const straight = this.straight.value;
    const slab = this.slab.value;
    const tilt = this.tilt.value ?? (slab.mm > 0 ? straightTilt(straight) : null);
    if (!tilt) return straight;
    const parts = { slab, spacing: this.spacing, id: ++this.obliqueId };
    return new Map(
      [...straight].map(([plane, stack]) => [plane, obliqueStack({ straight: stack, axes: tilt[plane], ...parts })]),
    );
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
      i === held.measure && isInSlice(one, stack, index)
        ? withCorner(stack, withHandle(stack, one, held.handle, to))
        : one,
    );
  }

  /** Adds a point in the shown slice to a measurement. */
  setPoint(stack: Stack, kind: MeasureKind, place: Vec3): void {
    const [plane, index] = stack.oblique ? [null, 0] : [stack.plane, this.index(stack)];
    this.setLast(stack, withPoint(this.measures.value, kind, plane, index, place));
  }

  moveLastPoint(stack: Stack, place: Vec3): void {
    this.setLast(stack, withLastPoint(this.measures.value, place));
  }

  private setLast(stack: Stack, measures: readonly Measure[]): void {
    this.measures.value = measures.map((one, i) => (i === measures.length - 1 ? withCorner(stack, one) : one));
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
      labels: this.labels.value,
      tilt: this.tilt.value,
      slab: this.slab.value,
      curve: this.curve.remembered(),
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
      labels: this.labelsShown.value ? this.labels.value.strength : 0,
      tilt: this.tilt.value,
      slab: this.slab.value,
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
      this.labels.value = { shown: presented.labels > 0, strength: presented.labels || firstLabels.strength };
      this.tilt.value = presented.tilt;
      this.slab.value = presented.slab;
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

  private restore(remembered: RememberedSlices): void {
    const { open, crosshair, window, measures, smooth, overlay, labels } = remembered;
    this.tilt.value = remembered.tilt;
    this.slab.value = remembered.slab;
    this.curve.restore(remembered.curve);
    const axial = this.stacks.value.get("axial");
    if (axial) this.pointAt(axial, crosshair);
    this.setWindow(window);
    this.measures.value = measures;
    this.smooth.value = smooth;
    this.overlay.value = overlay;
    this.labels.value = labels;
    this.open.value = open;
  }

  /** Resets the zoom, the crosshair, the window, the tilt and the slab. Measurements stay. */
  reset(): void {
    this.tilt.value = null;
    this.slab.value = noSlab;
    const axial = this.stacks.value.get("axial");
    this.crosshair.value = axial ? heldWithin(axial, middle) : middle;
    this.placings.value = {};
    this.window.value = this.first;
  }
}
