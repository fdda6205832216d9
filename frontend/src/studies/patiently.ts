import { after } from "../live/paced";
import { failureOf } from "./participation";

const againMs = 3000;

export interface Outcomes<T> {
  readonly done: (result: T) => void;
  /** Called with what was thrown if repeating the request would not help. */
  readonly refused: (thrown: unknown) => void;
  /** Called after each attempt that failed because the server is not there. */
  readonly waiting: () => void;
}

/** Sends a request until the server answers it. Returns a function that ends the attempts. */
export function patiently<T>(request: () => Promise<T>, { done, refused, waiting }: Outcomes<T>): () => void {
  let stopTimer: () => void = () => undefined;
  let here = true;
  const attempt = async (): Promise<void> => {
    try {
      const result = await request();
      if (here) done(result);
    } catch (thrown) {
      if (!here) return;
      if (failureOf(thrown).kind !== "again") {
        refused(thrown);
        return;
      }
      waiting();
      stopTimer = after(againMs, () => void attempt());
    }
  };
  void attempt();
  return () => {
    here = false;
    stopTimer();
  };
}
