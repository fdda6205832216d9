/** What was, for going back and forth. Values are whole and never changed, so steps share what they have in common. */
export interface History<Value> {
  readonly past: readonly Value[];
  readonly future: readonly Value[];
  /** The step that still grows. */
  readonly open: Step | null;
}

interface Step {
  readonly what: string;
  readonly held: boolean;
  readonly atMs: number;
}

export interface Change {
  /** What is changed: changes of one thing are one step while they come without a pause. */
  readonly what: string;
  /** A hand holds it: all is one step until it is lifted, however long it rests on the way. */
  readonly held: boolean;
  readonly nowMs: number;
}

export const mostSteps = 200;
/** Presses of a key and turns of a wheel that follow each other sooner are one step. */
export const togetherMs = 700;

export const nothingYet: History<never> = { past: [], future: [], open: null };

/** `before` is about to become something else. */
export function changed<Value>(history: History<Value>, before: Value, change: Change): History<Value> {
  const { open } = history;
  const goesOn =
    open?.what === change.what && open.held === change.held && (change.held || change.nowMs - open.atMs < togetherMs);
  const past = goesOn ? history.past : [...history.past, before].slice(-mostSteps);
  return { past, future: [], open: { what: change.what, held: change.held, atMs: change.nowMs } };
}

/** The hand was lifted: what comes next is another step. */
export const rested = <Value>(history: History<Value>): History<Value> =>
  history.open?.held ? { ...history, open: null } : history;

export interface Moved<Value> {
  readonly history: History<Value>;
  readonly value: Value;
}

/** One step back from `now`; nothing where there is none. */
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
