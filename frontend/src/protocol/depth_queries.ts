import { encodeDepthQuery } from "./messages";
import type { Depth } from "./gen/api/proto/stream_pb";

/** What is seen at a place of the picture; nothing where that is background, or nobody answered. */
export interface SeenPlace {
  /** mm from the eye along the view axis. */
  readonly distance: number;
}

export type Answered = { readonly answered: true; readonly seen: SeenPlace | null } | { readonly answered: false };

export interface QueryDependencies {
  readonly send: (message: Uint8Array<ArrayBuffer>) => boolean;
  readonly after: (ms: number, task: () => void) => () => void;
}

/** So long an answer is waited for: it takes milliseconds and the way there and back. */
export const patienceMs = 5000;

/** Questions about the picture, each with its answer. */
export class DepthQueries {
  private last = 0n;
  private readonly waiting = new Map<bigint, (answer: Answered) => void>();

  constructor(private readonly dependencies: QueryDependencies) {}

  /** `x` and `y` from 0 to 1, from the picture's upper left. */
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

  heard(depth: Depth): void {
    this.settle(depth.id, { answered: true, seen: depth.found ? { distance: depth.distance } : null });
  }

  /** Who was asked is gone. */
  lost(): void {
    for (const id of [...this.waiting.keys()]) this.settle(id, { answered: false });
  }

  private settle(id: bigint, answer: Answered): void {
    const settled = this.waiting.get(id);
    this.waiting.delete(id);
    settled?.(answer);
  }
}
