import { computed, effect, signal } from "@preact/signals";
import { add, scale, vec3, type Vec3 } from "../input/vec3";
import { inflate } from "./coding";
import type { Measure } from "./measure";
import type { RememberedSlices } from "./memory";
import { wholeSlice, type Placing } from "./placing";
import { heldWithin, inSlice, pixelOf, planes, type Plane, type Stack } from "./stack";
import { SliceStore, type Coming, type StoreParts } from "./store";
import { bounded, firstWindow, tableOf, type Window } from "./window";

/** The tool of the left button or of one finger. */
export const tools = ["window", "crosshair", "ruler", "angle"] as const;
export type Tool = (typeof tools)[number];

/** A single view, or all four. */
export type Shown = "picture" | "four" | Plane;

type Header = Parameters<typeof firstWindow>[0] & { readonly contentHash: string };
const middle = vec3(0, 0, 0);

/** The slices that the server sends to this viewer. `clipped` slices are blank outside the clip. */
export type Access = "none" | "clipped" | "whole";
/** The value of a clipped slice where nothing is shown. */
export const blank = -32768;

/** The state of the slice views. It persists while views open and close. */
export class Slices {
  readonly stacks = signal<ReadonlyMap<Plane, Stack>>(new Map());
  readonly access = signal<Access>("none");
  /** Whether there are slices to show. */
  readonly available = computed(() => this.access.value !== "none" && this.stacks.value.size > 0);
  /** If false, only the 3D picture is shown. */
  readonly open = signal(false);
  readonly shown = signal<Shown>("four");
  /** The page is too narrow for four views and shows one at a time. */
  readonly narrow = signal(false);
  readonly crosshair = signal<Vec3>(middle);
  readonly window = signal<Window>({ centre: 0, width: 1 });
  readonly tool = signal<Tool>("window");
  readonly measures = signal<readonly Measure[]>([]);
  readonly placings = signal<Partial<Record<Plane, Placing>>>({});
  /** The point under the pointer. */
  readonly pointed = signal<{ readonly plane: Plane; readonly place: Vec3 } | null>(null);
  /** Increases with every slice that arrives. */
  readonly came = signal(0);
  readonly damaged = signal(false);

  readonly view = computed<Shown>(() => {
    if (!this.open.value || !this.available.value) return "picture";
    return this.narrow.value && this.shown.value === "four" ? "axial" : this.shown.value;
  });
  readonly pictureShown = computed(() => this.view.value === "picture" || this.view.value === "four");
  /** The grey level of every 16-bit value. */
  readonly table = computed(() => tableOf(this.window.value));

  private readonly store: SliceStore;
  private readonly stopEffect: () => void;
  private first: Window = this.window.value;
  private volume: string | null = null;

  /** `before` is restored if it belongs to the volume. */
  constructor(
    ask: StoreParts["ask"],
    private before: RememberedSlices | null = null,
  ) {
    this.store = new SliceStore({
      ask,
      inflate,
      nextFrame: (task) => requestAnimationFrame(task),
      came: () => (this.came.value += 1),
      damaged: () => (this.damaged.value = true),
    });
    this.stopEffect = effect(() => {
      for (const plane of planes) {
        const stack = this.stacks.value.get(plane);
        const seen = stack && (this.view.value === "four" || this.view.value === plane);
        this.store.show(plane, seen ? pixelOf(stack, this.crosshair.value).slice : null);
      }
    });
  }

  /** Called on every connection to a worker. */
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
      this.reset();
      if (this.before?.volume === volume) this.restore(this.before);
      this.before = null;
    }
    this.store.connected();
  }

  allow(access: Access): void {
    if (access === this.access.value) return;
    if (access === "none") this.open.value = false;
    this.store.clear();
    this.access.value = access;
    this.came.value += 1;
  }

  /** Discards slices of an earlier clip. */
  stale(): void {
    this.store.clear();
    this.came.value += 1;
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
    return this.came.value >= 0 ? this.store.get({ plane: stack.plane, index: this.index(stack) }) : null;
  }

  valueAt(stack: Stack, place: Vec3): number | null {
    const { column, row } = pixelOf(stack, place);
    return this.values(stack)?.[row * stack.columns + column] ?? null;
  }

  scroll(stack: Stack, by: number): void {
    this.goTo(stack, this.index(stack) + by);
  }

  goTo(stack: Stack, index: number): void {
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

  /** Shows only one of the four views, or all four again. */
  maximise(one: Exclude<Shown, "four">): void {
    this.shown.value = this.view.value === one ? "four" : one;
  }

  /** What to restore after a reload, or null until there is a volume. */
  remembered(): RememberedSlices | null {
    if (this.volume === null) return this.before;
    return {
      volume: this.volume,
      open: this.open.value,
      crosshair: this.crosshair.value,
      window: this.window.value,
      measures: this.measures.value,
    };
  }

  private restore({ open, crosshair, window, measures }: RememberedSlices): void {
    const axial = this.stacks.value.get("axial");
    if (axial) this.pointAt(axial, crosshair);
    this.setWindow(window);
    this.measures.value = measures;
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
