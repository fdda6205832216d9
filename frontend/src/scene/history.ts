/** The undo history. Values are immutable, so steps share their common parts. */
export interface History<Value> {
  readonly past: readonly Value[];
  readonly future: readonly Value[];
  /** The step to which further changes may be added. */
  readonly open: Step | null;
}

interface Step {
  readonly what: string;
  readonly held: boolean;
  readonly atMs: number;
}

export interface Change {
  /** The changed setting. Changes of the same setting without a pause form one step. */
  readonly what: string;
  /** Whether a pointer holds the control. Everything until it is released is one step, however long it pauses. */
  readonly held: boolean;
  readonly nowMs: number;
}

export const mostSteps = 200;
/** Key presses and wheel turns that are closer together than this form one step. */
export const togetherMs = 700;

export const nothingYet: History<never> = { past: [], future: [], open: null };

/** Records that `before` is about to change. */
export function changed<Value>(history: History<Value>, before: Value, change: Change): History<Value> {
  const { open } = history;
  const goesOn =
    open?.what === change.what && open.held === change.held && (change.held || change.nowMs - open.atMs < togetherMs);
  const past = goesOn ? history.past : [...history.past, before].slice(-mostSteps);
  return { past, future: [], open: { what: change.what, held: change.held, atMs: change.nowMs } };
}

/** Ends the current step, because the control was released. */
export const rested = <Value>(history: History<Value>): History<Value> =>
  history.open?.held ? { ...history, open: null } : history;

export interface Moved<Value> {
  readonly history: History<Value>;
  readonly value: Value;
}

/** Goes one step back from `now`. Returns null if there is none. */
export function undone<Value>({ past, future }: History<Value>, now: Value): Moved<Value> | null {
  const value = past.at(-1);
  return value === undefined
    ? null
    : { value, history: { past: past.slice(0, -1), future: [...future, now], open: null } };
}

export function redone<Value>({ past, future }: History<Value>, now: Value): Moved<Value> | null {
  const value = future.at(-1);
  return value === undefined
    ? null
    : { value, history: { past: [...past, now], future: future.slice(0, -1), open: null } };
}
