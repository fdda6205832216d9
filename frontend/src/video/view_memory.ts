import { sceneFromJson, sceneToJson, type Scene } from "../protocol/messages";

/** The view of a data set, which this tab remembers across reloads. */
export interface RememberedView {
  readonly session_id: string | null;
  readonly scene: Scene | null;
  /** The scene at the start of the session. */
  readonly begun: Scene | null;
  readonly input_seq: number;
}

type Store = Pick<Storage, "getItem" | "setItem">;
const keyOf = (dataSetId: string) => `diaphane.view.${dataSetId}`;

export function rememberedView(store: Store, dataSetId: string): RememberedView {
  const nothing: RememberedView = { session_id: null, scene: null, begun: null, input_seq: 0 };
  try {
    const value = JSON.parse(store.getItem(keyOf(dataSetId)) ?? "null") as Record<string, unknown> | null;
    if (!value) return nothing;
    const { session_id: sessionId, scene, begun, input_seq: inputSeq } = value;
    return {
      session_id: typeof sessionId === "string" ? sessionId : null,
      scene: typeof scene === "string" ? sceneFromJson(scene) : null,
      begun: typeof begun === "string" ? sceneFromJson(begun) : null,
      input_seq: typeof inputSeq === "number" && Number.isSafeInteger(inputSeq) ? inputSeq : 0,
    };
  } catch {
    return nothing;
  }
}

export function rememberView(store: Store, dataSetId: string, view: RememberedView): void {
  const text = (scene: Scene | null) => (scene ? sceneToJson(scene) : null);
  try {
    store.setItem(keyOf(dataSetId), JSON.stringify({ ...view, scene: text(view.scene), begun: text(view.begun) }));
  } catch {
    // The storage is full or not allowed, so the view starts again after a reload.
  }
}
