import type { AnonymiseApi } from "../api/anonymise";
import { ApiProblem } from "../api/client";
import type { RegionBody } from "./region";

/** The outcome of a cut. `problem` is the server's explanation of a failure, or empty. */
export type CutOutcome = "done" | { readonly problem: string };

export interface CutSteps {
  readonly api: Pick<AnonymiseApi, "look" | "cut">;
  /** Waits before the next request for the state. */
  readonly pause: () => Promise<void>;
  /** Whether nobody waits for the outcome any longer. */
  readonly isOver: () => boolean;
}

/**
 * Cuts a scan permanently and waits for the outcome, or returns null if nobody waits any longer. An
 * outcome counts only once the server has the request, because an earlier cut may have left one.
 * @throws if nothing was sent, if the server refused it, or if it no longer shows the user the scan.
 */
export async function carryOutCut(
  { api, pause, isOver }: CutSteps,
  id: string,
  keep: RegionBody,
  volumeHash: string,
): Promise<CutOutcome | null> {
  const before = await api.look(id);
  const isUnanswered = await api.cut(id, keep, volumeHash).then(
    () => false,
    (thrown: unknown) => {
      if (isUncertain(thrown)) return true;
      throw thrown;
    },
  );
  if (isUnanswered) await pause(); // the request may still be on its way
  while (!isOver()) {
    const now = await api.look(id).catch((thrown: unknown) => {
      if (isUncertain(thrown)) return null; // the next one may succeed
      throw thrown;
    });
    if (now?.state === "ready") {
      if (now.anonymised_at !== before.anonymised_at) return "done";
      return { problem: isUnanswered && now.problem === before.problem ? "" : (now.problem ?? "") };
    }
    await pause();
  }
  return null;
}

/** Whether a request may have reached the server although there is no proper answer. */
const isUncertain = (thrown: unknown): boolean =>
  !(thrown instanceof ApiProblem) || thrown.status === 0 || thrown.status >= 500;
