import { computed, effect, signal, untracked, type ReadonlySignal } from "@preact/signals";
import type { Audience } from "../protocol/messages";
import {
  encodeGuestPointers,
  encodeMeasurements,
  encodePointer,
  encodeSharedTaken,
  encodeSliceView,
  measuresOf,
  pointersOf,
  presentedOf,
  type Pointer,
  type PointerAt,
  type SharedState,
} from "../protocol/shared_messages";
import type { Slices } from "../slices/model";
import type { PresentedSlices } from "../slices/presented";
import { Paced, type After } from "./paced";
import { roleOf } from "./role";

export interface CollaborationParts {
  /** Sends a message now. Returns false without a connection. */
  readonly say: (message: Uint8Array<ArrayBuffer>) => boolean;
  readonly after: After;
  readonly slices: Slices;
  readonly audience: ReadonlySignal<Audience | null>;
}

export const sharedEveryMs = 100;
/** Delay before an update is acknowledged. The server sends no other one until then. */
const takenAfterMs = 50;
/** A pointer that has not moved for this long is hidden. */
export const pointerForMs = 4000;

/**
 * What the participants of a live session show each other: the presenter's slices and measurements, and everyone's
 * pointer. A viewer who is alone sends nothing.
 */
export class Collaboration {
  /** The pointers of the others, by number. */
  readonly pointers = signal<ReadonlyMap<number, Pointer>>(new Map());
  private readonly role = computed(() => roleOf(this.parts.audience.value));
  readonly people = computed(() => this.role.value.people);
  /** Whether this viewer's pointer can be seen. */
  readonly points = computed(() => {
    const { others, presents, guest } = this.role.value;
    return others > 0 && (presents || !guest || (this.parts.audience.value?.guestPointers ?? false));
  });

  private readonly presented = signal<PresentedSlices | null>(null);
  private readonly presents = computed(() => this.role.value.presents);
  private readonly shares = computed(
    () => this.presents.value && this.role.value.others > 0 && this.parts.slices.available.value,
  );
  private readonly follows = computed(() => this.role.value.follows && !this.role.value.freeCamera);
  /** Increases with each connection, because a new worker knows nothing. */
  private readonly connections = signal(0);
  private guestPointers = true;
  /** Whether this is a new connection, whose worker may not know this viewer's choice yet. */
  private isNewConnection = true;
  private pointing = false;
  private readonly expiries = new Map<number, () => void>();
  private readonly stops: readonly (() => void)[];

  private readonly views: Paced<PresentedSlices>;
  private readonly measurements: Paced<Parameters<typeof encodeMeasurements>[0]>;
  private readonly moves: Paced<PointerAt | null>;

  constructor(private readonly parts: CollaborationParts) {
    const { slices, after, say } = parts;
    this.views = new Paced(sharedEveryMs, after, (view) => say(encodeSliceView(view)));
    this.measurements = new Paced(sharedEveryMs, after, (measures) => say(encodeMeasurements(measures)));
    this.moves = new Paced(sharedEveryMs, after, (at) => say(encodePointer(at)));
    this.stops = [
      effect(() => {
        if (this.shares.value && this.connections.value > 0) this.views.push(slices.presented());
      }),
      effect(() => {
        if (this.shares.value && this.connections.value > 0) this.measurements.push(slices.presentedMeasurements());
      }),
      effect(() => this.takeRole()),
    ];
  }

  connected(): void {
    this.isNewConnection = true;
    this.connections.value += 1;
  }

  audienceChanged(audience: Audience): void {
    if (this.presents.value && this.isNewConnection && audience.guestPointers && !this.guestPointers)
      this.setGuestPointers(false);
    this.isNewConnection = false;
    const numbers = new Set(
      audience.participants
        .filter(({ owner, presenter }) => owner || presenter || audience.guestPointers)
        .map(({ number }) => number),
    );
    for (const number of this.pointers.value.keys()) if (!numbers.has(number)) this.hide(number);
  }

  receive(shared: SharedState): void {
    this.parts.after(takenAfterMs, () => this.parts.say(encodeSharedTaken(shared.seq)));
    if (shared.measurements) this.parts.slices.followMeasurements(measuresOf(shared.measurements));
    if (shared.sliceView) this.presented.value = presentedOf(shared.sliceView);
    for (const { shown, ...pointer } of pointersOf(shared)) {
      if (shown) this.show(pointer);
      else this.hide(pointer.number);
    }
  }

  /** Moves this viewer's pointer, or hides it if `at` is null. */
  point(at: PointerAt | null): void {
    if (!this.points.value || (!at && !this.pointing)) return;
    this.pointing = at !== null;
    this.moves.push(at);
  }

  setGuestPointers(on: boolean): void {
    this.guestPointers = on;
    this.parts.say(encodeGuestPointers(on));
  }

  stop(): void {
    for (const stop of this.stops) stop();
    for (const cancel of this.expiries.values()) cancel();
    for (const paced of [this.views, this.measurements, this.moves]) paced.stop();
  }

  /** Follows the presenter's slices, or continues with them as the presenter. */
  private takeRole(): void {
    const { slices } = this.parts;
    const presented = this.presented.value;
    const presents = this.presents.value;
    const follows = this.follows.value && slices.available.value;
    untracked(() => {
      if (presents) slices.takeOver();
      else if (!follows) slices.unfollow();
      else if (presented) slices.follow(presented);
    });
  }

  private show(pointer: Pointer): void {
    this.pointers.value = new Map(this.pointers.value).set(pointer.number, pointer);
    this.expiries.get(pointer.number)?.();
    this.expiries.set(
      pointer.number,
      this.parts.after(pointerForMs, () => this.hide(pointer.number)),
    );
  }

  private hide(number: number): void {
    this.expiries.get(number)?.();
    this.expiries.delete(number);
    if (!this.pointers.value.has(number)) return;
    const left = new Map(this.pointers.value);
    left.delete(number);
    this.pointers.value = left;
  }
}
