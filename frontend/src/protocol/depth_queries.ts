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

/** Matches queries about the picture with their answers. */
export class DepthQueries {
  private last = 0n;
  private readonly waiting = new Map<bigint, (answer: Answered) => void>();

  constructor(private readonly dependencies: QueryDependencies) {}

  /**
   * Asks for the surface at a point. `x` and `y` range from 0 to 1, from the top left of the
   * picture.
   */
  ask(x: number, y: number): Promise<Answered> {
    const id = ++this.last;
    if (!this.dependencies.send(encodeDepthQuery(id, x, y))) return Promise.resolve({ answered: false });
    return new Promise((resolve) => {
      const disarm = this.dependencies.after(patienceMs, () => this.settle(id, { answered: false }));
      this.waiting.set(id, (answer) => {
        disarm();
        resolve(answer);
      });
    });
  }

  receive(depth: Depth): void {
    const { x = 0, y = 0, z = 0 } = depth.place ?? {};
    const seen = depth.found ? { distance: depth.distance, place: vec3(x, y, z), label: depth.label } : null;
    this.settle(depth.id, { answered: true, seen });
  }

  /** Ends all queries, because the connection is lost. */
  lost(): void {
    for (const id of [...this.waiting.keys()]) this.settle(id, { answered: false });
  }

  private settle(id: bigint, answer: Answered): void {
    const settled = this.waiting.get(id);
    this.waiting.delete(id);
    settled?.(answer);
  }
}
