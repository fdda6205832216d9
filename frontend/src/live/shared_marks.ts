import { computed, effect, signal, type ReadonlySignal } from "@preact/signals";
import { keyOf, type Marks } from "../marks/marks";
import { mostMarks, type Mark } from "../marks/mark";
import type { Audience } from "../protocol/messages";
import { encodeMarks, encodeMarkSightQuery, sharedMarksOf, type MarkSight } from "../protocol/mark_messages";
import type { SharedState } from "../protocol/shared_messages";
import { Paced, type After } from "./paced";
import { roleOf } from "./role";

export interface SharedMarksParts {
  /** Sends a message now. Returns false without a connection. */
  readonly say: (message: Uint8Array<ArrayBuffer>) => boolean;
  readonly after: After;
  readonly marks: Marks;
  readonly audience: ReadonlySignal<Audience | null>;
  /** Changes with each picture of another view. */
  readonly view: ReadonlySignal<unknown>;
}

export const marksEveryMs = 100;
export const sightEveryMs = 300;

/**
 * Shows this viewer's marks to the others and theirs here, and asks which marks lie behind matter. The worker gets the
 * marks of a viewer who is alone as well, because it needs them for the answer.
 */
export class SharedMarks {
  private readonly connections = signal(0);
  private sent = false;
  private readonly own: Paced<readonly Mark[]>;
  private readonly sights: Paced<null>;
  private readonly stops: readonly (() => void)[];

  constructor(private readonly parts: SharedMarksParts) {
    const { marks, after, say, audience, view } = parts;
    this.sights = new Paced(sightEveryMs, after, () => say(encodeMarkSightQuery()));
    this.own = new Paced(marksEveryMs, after, (items) => {
      if (say(encodeMarks(items))) this.askForSight();
    });
    const allowed = computed(() => {
      const { guest, presents } = roleOf(audience.value);
      return audience.value !== null && (!guest || presents || audience.value.guestPointers);
    });
    const mine = computed(() => (marks.shown.value ? marks.items.value.slice(-mostMarks) : none));
    this.stops = [
      effect(() => {
        const items = mine.value;
        if (this.connections.value === 0 || !allowed.value || (items.length === 0 && !this.sent)) return;
        this.sent = true;
        this.own.push(items);
      }),
      effect(() => {
        if (view.value !== null && marks.others.value.size + mine.value.length > 0) this.askForSight();
      }),
    ];
  }

  /** Sends the marks again, because a new worker knows none. */
  connected(): void {
    this.sent = false;
    this.parts.marks.others.value = new Map();
    this.connections.value += 1;
  }

  /** Removes the marks of participants who have left. */
  audienceChanged(audience: Audience): void {
    const { others } = this.parts.marks;
    const numbers = new Set(audience.participants.map(({ number }) => number));
    const left = [...others.value].filter(([number]) => numbers.has(number));
    if (left.length < others.value.size) others.value = new Map(left);
  }

  receive(shared: SharedState): void {
    const changed = sharedMarksOf(shared);
    if (changed.length === 0) return;
    const { others } = this.parts.marks;
    others.value = new Map([...new Map([...others.value, ...changed])].filter(([, marks]) => marks.length > 0));
  }

  receiveSight({ hidden }: MarkSight): void {
    this.parts.marks.hidden.value = new Set(hidden.flatMap(({ number, ids }) => ids.map((id) => keyOf(number, id))));
  }

  stop(): void {
    for (const stop of this.stops) stop();
    this.own.stop();
    this.sights.stop();
  }

  private askForSight(): void {
    this.sights.push(null);
  }
}

const none: readonly Mark[] = [];
