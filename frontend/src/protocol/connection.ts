/**
 * The connection to a render worker as a pure state machine: an event goes in, and the next state and its effects come
 * out. StreamClient executes the effects. Contains no clock, socket or timer.
 */

export type Phase =
  | "idle"
  | "asking" // for a ticket
  | "opening" // the socket
  | "greeting" // hello is sent, the configuration is awaited
  | "live"
  | "waiting" // for the next try
  | "elsewhere" // another window took over the session; continues here on request
  | "stopped";

/** Why there is no picture, or no new one, as a key of the texts. */
export type Trouble =
  | "lost"
  | "worker_lost"
  | "no_worker"
  | "guests_full"
  | "unreachable"
  | "not_found"
  | "not_ready"
  | "signed_out"
  | "refused"
  | "taken_over"
  | "link_ended"
  | "displaced"
  | "time_spent";

export interface ConnectionState {
  readonly phase: Phase;
  /** Number of attempts since the last picture arrived. */
  readonly attempt: number;
  /** Whether a worker was connected before, so that this is a reconnection. */
  readonly wasLive: boolean;
  readonly trouble: Trouble | null;
}

export type ConnectionEvent =
  | { readonly kind: "start" }
  | { readonly kind: "ticket"; readonly url: string }
  | { readonly kind: "no_ticket"; readonly trouble: Trouble; readonly final: boolean; readonly retryAfterMs?: number }
  | { readonly kind: "opened" }
  | { readonly kind: "configured" }
  | { readonly kind: "picture" }
  | { readonly kind: "closed"; readonly code: number }
  | { readonly kind: "lost" } // the connection is open, but the server can't be reached
  | { readonly kind: "timeout" } // of a wait, or of a step that took too long
  | { readonly kind: "again" } // the page itself asked for a new greeting
  | { readonly kind: "wake" } // the network is back, or the page is visible again
  | { readonly kind: "stop" };

export type ConnectionEffect =
  | { readonly kind: "ask_ticket" }
  | { readonly kind: "open"; readonly url: string }
  | { readonly kind: "greet" }
  | { readonly kind: "close" }
  /** Deliver `timeout` after this time, unless another effect with a timer, or `disarm`, comes first. */
  | { readonly kind: "timer"; readonly ms: number }
  | { readonly kind: "disarm" };

export interface Step {
  readonly state: ConnectionState;
  readonly effects: readonly ConnectionEffect[];
}

export const firstState: ConnectionState = { phase: "idle", attempt: 0, wasLive: false, trouble: null };

/**
 * Whether there are no more pictures, because a visit has ended or the rendering time is used up.
 */
export const isOver = (state: ConnectionState): boolean => isVisitOver(state) || state.trouble === "time_spent";

/** Whether a visit has ended, so that nothing of the scan may be shown or saved any longer. */
export const isVisitOver = ({ trouble }: ConnectionState): boolean => trouble === "link_ended";

const stepLimitMs = 10_000;
const waitsMs = [150, 300, 600, 1000, 1500, 2000];
const longestWaitMs = 5000;

/**
 * Returns the wait before attempt number `attempt` (from 0). A random `spread` in [0, 1) keeps many pages from
 * reconnecting at the same time.
 */
export function waitMs(attempt: number, spread: number, retryAfterMs = 0): number {
  const base = attempt < waitsMs.length ? (waitsMs[attempt] ?? longestWaitMs) : attempt < 30 ? 2000 : longestWaitMs;
  return Math.max(base, Math.min(retryAfterMs, longestWaitMs)) * (0.8 + 0.4 * spread);
}

const ask = (from: ConnectionState): Step => ({
  state: { ...from, phase: "asking" },
  effects: [{ kind: "ask_ticket" }, { kind: "timer", ms: stepLimitMs }],
});

const retryLater = (state: ConnectionState, spread: number, trouble: Trouble, retryAfterMs = 0): Step => ({
  state: { ...state, phase: "waiting", attempt: state.attempt + 1, trouble },
  effects: [{ kind: "close" }, { kind: "timer", ms: waitMs(state.attempt, spread, retryAfterMs) }],
});

/** Returns the next step after an event. `spread` is a random number in [0, 1) from the caller. */
export function advance(state: ConnectionState, event: ConnectionEvent, spread: number): Step {
  const stay: Step = { state, effects: [] };
  if (state.phase === "stopped") return stay;
  switch (event.kind) {
    case "start":
      return state.phase === "idle" || state.phase === "elsewhere" ? ask({ ...state, trouble: null }) : stay;
    case "stop":
      return { state: { ...state, phase: "stopped" }, effects: [{ kind: "disarm" }, { kind: "close" }] };
    case "ticket":
      if (state.phase !== "asking") return stay;
      return {
        state: { ...state, phase: "opening" },
        effects: [
          { kind: "open", url: event.url },
          { kind: "timer", ms: stepLimitMs },
        ],
      };
    case "no_ticket":
      if (state.phase !== "asking") return stay;
      if (event.final)
        return { state: { ...state, phase: "stopped", trouble: event.trouble }, effects: [{ kind: "disarm" }] };
      return retryLater(state, spread, event.trouble, event.retryAfterMs);
    case "opened":
      if (state.phase !== "opening") return stay;
      return {
        state: { ...state, phase: "greeting" },
        effects: [{ kind: "greet" }, { kind: "timer", ms: stepLimitMs }],
      };
    case "configured":
      if (state.phase !== "greeting") return stay;
      return { state: { ...state, phase: "live", wasLive: true, trouble: null }, effects: [{ kind: "disarm" }] };
    case "picture":
      // Only a picture resets the attempts, so that the page waits between connections to a worker that greets and then
      // dies.
      return state.phase === "live" && state.attempt > 0 ? { state: { ...state, attempt: 0 }, effects: [] } : stay;
    case "closed":
      if (state.phase !== "opening" && state.phase !== "greeting" && state.phase !== "live") return stay;
      return afterClose(state, event.code, spread);
    case "lost":
      return state.phase === "live" ? retryLater(state, spread, "lost") : stay;
    case "timeout":
      if (state.phase === "waiting") return ask(state);
      if (state.phase === "asking" || state.phase === "opening" || state.phase === "greeting")
        return retryLater(state, spread, "unreachable");
      return stay;
    case "again": {
      if (state.phase !== "live") return stay; // the next greeting is still to come
      const { state: next, effects } = ask(state);
      return { state: next, effects: [{ kind: "close" }, ...effects] };
    }
    case "wake":
      return state.phase === "waiting" ? ask(state) : stay;
  }
}

/** Close codes of docs/contracts.md, "Stream". */
const takenOver = 4409;
const linkEnded = 4410;
const displaced = 4411;

/**
 * Close codes after which the page does not reconnect automatically. Otherwise, two windows would
 * take the session from each other for ever.
 */
const finalCloses: Readonly<Record<number, Pick<ConnectionState, "phase" | "trouble">>> = {
  [takenOver]: { phase: "elsewhere", trouble: "taken_over" },
  [linkEnded]: { phase: "stopped", trouble: "link_ended" },
  [displaced]: { phase: "stopped", trouble: "displaced" },
};

function afterClose(state: ConnectionState, code: number, spread: number): Step {
  const final = finalCloses[code];
  if (!final) return retryLater(state, spread, troubleOfClose(code));
  return { state: { ...state, ...final }, effects: [{ kind: "disarm" }, { kind: "close" }] };
}

function troubleOfClose(code: number): Trouble {
  switch (code) {
    case 4503:
      return "worker_lost";
    case 4429:
      return "no_worker";
    case 4400:
    case 1009:
      return "refused";
    default:
      return "lost";
  }
}
