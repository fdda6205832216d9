import type { Send } from "./sharing";

/** How a second scan lies in the space of a first one. */
export interface Alignment {
  /** "none": it was never requested. */
  readonly state: "none" | "waiting" | "running" | "ready" | "failed";
  /** Whether both scans have the same frame of reference, so that nothing has to be aligned. */
  readonly frame_of_reference_shared: boolean;
  /** Row-major 4 x 4, from the patient coordinates of the second scan to those of the first, in mm. */
  readonly matrix: readonly number[] | null;
  /** The same between the coordinates of their pictures. */
  readonly scene_matrix: readonly number[] | null;
  /** The expected distance between the same places in both scans, after the alignment. */
  readonly residual_mm: number | null;
  /** The share of the smaller scan that lies in the other, 0 to 1. */
  readonly overlap: number | null;
  /** Why it failed, as a code. */
  readonly reason: string | null;
  /** Whether this user may align the scans, because one of them is theirs. */
  readonly may_align: boolean;
}

const path = (first: string, second: string): string => `/v1/data-sets/${first}/alignments/${second}`;

export class AlignmentsApi {
  constructor(private readonly send: Send) {}

  async state(first: string, second: string): Promise<Alignment> {
    return (await (await this.send("GET", path(first, second))).json()) as Alignment;
  }

  /** Requests the alignment, or returns the one that exists. */
  async request(first: string, second: string): Promise<Alignment> {
    return (await (await this.send("PUT", path(first, second))).json()) as Alignment;
  }

  async remove(first: string, second: string): Promise<void> {
    await this.send("DELETE", path(first, second));
  }
}
