import { sceneFromJson, sceneToJson, type Scene } from "../protocol/messages";
import { nothingYet, type History } from "../scene/history";

/** The view of a data set, which this tab remembers across reloads. */
export interface RememberedView {
  readonly session_id: string | null;
  readonly scene: Scene | null;
  /** The scene at the start of the session. */
  readonly begun: Scene | null;
  readonly input_seq: number;
  /** The steps to undo and to redo. */
  readonly steps: History<Scene>;
}

type Store = Pick<Storage, "getItem" | "setItem">;
export const marksKey = (dataSetId: string): string => `diaphane.marks.${dataSetId}`;
export const slicesKey = (dataSetId: string): string => `diaphane.slices.${dataSetId}`;
const keyOf = (dataSetId: string) => `diaphane.view.${dataSetId}`;
const stepsKeyOf = (dataSetId: string) => `diaphane.steps.${dataSetId}`;

/**
 * Limit for the undo steps, because browsers store about 5 million characters for a tab. Older
 * steps do not survive a reload.
 */
const mostStepCharacters = 1_000_000;

export function rememberedView(store: Store, dataSetId: string): RememberedView {
  const nothing: RememberedView = { session_id: null, scene: null, begun: null, input_seq: 0, steps: nothingYet };
  try {
    const value = JSON.parse(store.getItem(keyOf(dataSetId)) ?? "null") as Record<string, unknown> | null;
    if (!value) return nothing;
    const { session_id: sessionId, scene, begun, input_seq: inputSeq } = value;
    return {
      session_id: typeof sessionId === "string" ? sessionId : null,
      scene: typeof scene === "string" ? sceneFromJson(scene) : null,
      begun: typeof begun === "string" ? sceneFromJson(begun) : null,
      input_seq: typeof inputSeq === "number" && Number.isSafeInteger(inputSeq) ? inputSeq : 0,
      steps: rememberedSteps(store, dataSetId),
    };
  } catch {
    return nothing;
  }
}

export function rememberView(store: Store, dataSetId: string, view: RememberedView): void {
  const text = (scene: Scene | null) => (scene ? sceneToJson(scene) : null);
  const { steps, ...rest } = view;
  try {
    store.setItem(keyOf(dataSetId), JSON.stringify({ ...rest, scene: text(view.scene), begun: text(view.begun) }));
    rememberSteps(store, dataSetId, steps);
  } catch {
    // The storage is full or not allowed, so the view starts again after a reload.
  }
}

/** Forgets a view, with its marks and slices. */
export function forgetView(store: Pick<Storage, "removeItem">, dataSetId: string): void {
  for (const key of [keyOf, stepsKeyOf, marksKey, slicesKey]) store.removeItem(key(dataSetId));
}

/** The last content of each store, because views are remembered several times per second. */
const written = new WeakMap<Store, { readonly dataSetId: string; readonly steps: History<Scene> }>();
/**
 * The JSON text of scenes, cached because scenes are immutable and most steps were written before.
 */
const texts = new WeakMap<Scene, string>();

function rememberSteps(store: Store, dataSetId: string, steps: History<Scene>): void {
  const last = written.get(store);
  if (last?.dataSetId === dataSetId && last.steps === steps) return;
  written.set(store, { dataSetId, steps });
  let left = mostStepCharacters;
  const newest = (scenes: readonly Scene[]): string[] => {
    const fitting: string[] = [];
    for (const scene of scenes.toReversed()) {
      const text = texts.get(scene) ?? sceneToJson(scene);
      texts.set(scene, text);
      left -= text.length;
      if (left < 0) break;
      fitting.unshift(text);
    }
    return fitting;
  };
  store.setItem(stepsKeyOf(dataSetId), JSON.stringify({ past: newest(steps.past), future: newest(steps.future) }));
}

function rememberedSteps(store: Store, dataSetId: string): History<Scene> {
  const value = JSON.parse(store.getItem(stepsKeyOf(dataSetId)) ?? "{}") as Record<string, unknown>;
  const scenes = (list: unknown): Scene[] =>
    (Array.isArray(list) ? list : []).flatMap((text) => {
      const scene = typeof text === "string" ? sceneFromJson(text) : null;
      return scene ? [scene] : [];
    });
  return { past: scenes(value.past), future: scenes(value.future), open: null };
}
