import { signal } from "@preact/signals";
import { ApiProblem } from "../api/client";
import type { JoinedStudy, StudiesApi } from "../api/studies";
import type { After } from "../live/paced";
import { AnswerQueue, type Failure, type Over } from "./answer_queue";
import type { Answer, Step } from "./definition";
import { orderedSteps } from "./order";
import { forgetView } from "../video/view_memory";

export type ParticipantApi = Pick<StudiesApi, "answer" | "record" | "finish" | "withdraw">;
export type ParticipantStore = Pick<Storage, "getItem" | "setItem" | "removeItem">;

/** Returns what a failed request of a participant means. Only 410 ends the participation. */
export function failureOf(thrown: unknown): Failure {
  if (!(thrown instanceof ApiProblem)) return { kind: "again", retryAfterMs: 0 };
  if (thrown.status === 410) return { kind: "over", why: thrown.kind === "participation-ended" ? "gone" : "over" };
  const again = thrown.status === 0 || thrown.status === 408 || thrown.status === 429 || thrown.status >= 500;
  return again ? { kind: "again", retryAfterMs: thrown.retryAfterMs } : { kind: "refused" };
}

/** Returns the answers of a participant that this tab has not sent yet. */
export const queueOf = (
  api: Pick<ParticipantApi, "answer" | "record">,
  key: string,
  store: ParticipantStore,
  after: After,
): AnswerQueue =>
  new AnswerQueue({
    store,
    key: `diaphane.study.answers.${key.slice(0, 8)}`,
    send: (item) =>
      item.kind === "answer"
        ? api.answer(key, item.step, item.value, item.duration_ms, item.sequence)
        : api.record(key, item.step, item.recording),
    failureOf,
    after,
  });

/** The names under which this tab keeps the trials and the view of a step until it is answered. */
export const trialsKey = (key: string, step: string): string => `diaphane.study.trials.${key.slice(0, 8)}.${step}`;
export const viewKey = (key: string, step: string): string => `study.${key.slice(0, 8)}.${step}`;

/** The server refuses a longer time, and with it the answer. */
const longestStepMs = 86_400_000;

/** One participant on their way through the steps. */
export class Participation {
  /** The steps in this participant's order. Joining was the answer to the consent. */
  readonly steps: readonly Step[];
  readonly queue: AnswerQueue;
  private readonly done = signal<ReadonlySet<string>>(new Set());

  constructor(
    private readonly api: ParticipantApi,
    readonly key: string,
    readonly joined: JoinedStudy,
    /** Whether this participant agreed to a recording. */
    readonly record: boolean,
    private readonly store: ParticipantStore,
    after: After,
  ) {
    this.steps = orderedSteps(joined.definition.steps, joined.seed).filter(({ kind }) => kind !== "consent");
    this.queue = queueOf(api, key, store, after);
    this.queue.continueAfter(joined.sequence);
    const pending = this.queue.pending.value.flatMap((one) => (one.kind === "answer" ? [one.step] : []));
    this.done.value = new Set([...joined.answered, ...pending]);
  }

  /** Returns the first step without an answer, or null after the last one. */
  current(): Step | null {
    return this.steps.find(({ id }) => !this.done.value.has(id)) ?? null;
  }

  isAnswered(step: string): boolean {
    return this.done.value.has(step);
  }

  /** Number of answered steps. */
  answered(): number {
    return this.steps.filter(({ id }) => this.done.value.has(id)).length;
  }

  answer(step: Step, value: Answer, durationMs: number): void {
    this.queue.answer(step.id, value, Math.min(durationMs, longestStepMs));
    this.done.value = new Set([...this.done.value, step.id]);
  }

  /** Finishes once the server has all answers. */
  async finish(): Promise<void> {
    await this.queue.whenEmpty();
    if (this.queue.over.value === null) await this.api.finish(this.key);
  }

  /** Ends the participation if a failed request means that the study is over. Returns whether it does. */
  endIfOver(thrown: unknown): boolean {
    const failure = failureOf(thrown);
    if (failure.kind === "over") this.queue.end(failure.why);
    return failure.kind === "over";
  }

  /** Forgets what this tab has kept of the steps, after the end. */
  forgetSteps(): void {
    for (const { id } of this.steps) {
      this.store.removeItem(trialsKey(this.key, id));
      forgetView(this.store, viewKey(this.key, id));
    }
  }

  /** Deletes the participant and their answers. */
  async withdraw(): Promise<void> {
    await this.api.withdraw(this.key);
    this.queue.clear();
    this.forgetSteps();
  }
}

interface Kept {
  readonly key: string;
  readonly record: boolean;
  /** How the participation ended, if it has. */
  readonly ended: Ending | null;
}
export type Ending = "finished" | "kept" | "deleted" | Over;

const nameOf = (token: string): string => `diaphane.study.${token.slice(0, 8)}`;

/** Returns the participant that this tab has for a link, so that a reload continues where it was. */
export function keptParticipant(store: ParticipantStore, token: string): Kept | null {
  try {
    const value = JSON.parse(store.getItem(nameOf(token)) ?? "null") as Partial<Kept> | null;
    if (typeof value?.key !== "string" || !/^[0-9a-f]{64}$/.test(value.key)) return null;
    return { key: value.key, record: value.record === true, ended: value.ended ?? null };
  } catch {
    return null;
  }
}

export const keepParticipant = (store: ParticipantStore, token: string, kept: Kept): void =>
  store.setItem(nameOf(token), JSON.stringify(kept));
