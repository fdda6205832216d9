import { vec3, type Vec3 } from "../input/vec3";
import { encodeDepthQuery } from "./messages";
import type { Depth } from "./gen/api/proto/stream_pb";

/** The surface at a point of the picture. */
export interface SeenPlace {
  /** Distance from the eye along the view axis, in mm. */
  readonly distance: number;
  /** In mm in world space. */
  readonly place: Vec3;
  /** The number of the label there, or 0. */
  readonly label: number;
}

export type Answered = { readonly answered: true; readonly seen: SeenPlace | null } | { readonly answered: false };

export interface QueryDependencies {
  readonly send: (message: Uint8Array<ArrayBuffer>) => boolean;
  readonly after: (ms: number, task: () => void) => () => void;
}

/** Time to wait for an answer, which normally takes milliseconds and a round trip. */
export const patienceMs = 5000;
/** Pause after an answer. The renderer refuses a query within 50 ms of the one before. */
export const pauseMs = 60;

interface Query {
  readonly x: number;
  readonly y: number;
  readonly resolve: (answer: Answered) => void;
}

/** Sends queries about the picture one after the other, and matches them with their answers. */
export class DepthQueries {
  private last = 0n;
  private readonly coming: Query[] = [];
  /** The query without an answer. */
  private open: { readonly id: bigint; readonly query: Query; readonly disarm: () => void } | null = null;
  private pausing = false;

  constructor(private readonly dependencies: QueryDependencies) {}

  /**
   * Asks for the surface at a point. `x` and `y` range from 0 to 1, from the top left of the
   * picture.
   */
  ask(x: number, y: number): Promise<Answered> {
    return new Promise((resolve) => {
      this.coming.push({ x, y, resolve });
      this.next();
    });
  }

  receive(depth: Depth): void {
    const { x = 0, y = 0, z = 0 } = depth.place ?? {};
    const seen = depth.found ? { distance: depth.distance, place: vec3(x, y, z), label: depth.label } : null;
    this.settle(depth.id, { answered: true, seen });
  }

  /** Ends all queries, because the connection is lost. */
  lost(): void {
    const coming = this.coming.splice(0);
    if (this.open) this.settle(this.open.id, { answered: false });
    for (const { resolve } of coming) resolve({ answered: false });
  }

  private next(): void {
    if (this.open || this.pausing) return;
    const query = this.coming.shift();
    if (!query) return;
    const id = ++this.last;
    if (this.dependencies.send(encodeDepthQuery(id, query.x, query.y))) {
      const disarm = this.dependencies.after(patienceMs, () => this.settle(id, { answered: false }));
      this.open = { id, query, disarm };
    } else {
      query.resolve({ answered: false });
      this.next();
    }
  }

  private settle(id: bigint, answer: Answered): void {
    const { open } = this;
    if (open?.id !== id) return;
    this.open = null;
    this.pausing = true;
    open.disarm();
    open.query.resolve(answer);
    this.dependencies.after(pauseMs, () => {
      this.pausing = false;
      this.next();
    });
  }
}
