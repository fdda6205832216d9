import { scene_from_json, scene_to_json, type Scene } from "../protocol/messages";

/** Where a person was in a data set: kept for this tab alone, over a reload. */
export interface RememberedView {
  readonly session_id: string | null;
  readonly scene: Scene | null;
  /** What the session began with. */
  readonly begun: Scene | null;
  readonly input_seq: number;
}

type Store = Pick<Storage, "getItem" | "setItem">;
const key_of = (data_set_id: string) => `diaphane.view.${data_set_id}`;

export function remembered_view(store: Store, data_set_id: string): RememberedView {
  const nothing: RememberedView = { session_id: null, scene: null, begun: null, input_seq: 0 };
  try {
    const value = JSON.parse(store.getItem(key_of(data_set_id)) ?? "null") as Record<string, unknown> | null;
    if (!value) return nothing;
    const { session_id, scene, begun, input_seq } = value;
    return {
      session_id: typeof session_id === "string" ? session_id : null,
      scene: typeof scene === "string" ? scene_from_json(scene) : null,
      begun: typeof begun === "string" ? scene_from_json(begun) : null,
      input_seq: typeof input_seq === "number" && Number.isSafeInteger(input_seq) ? input_seq : 0,
    };
  } catch {
    return nothing;
  }
}

export function remember_view(store: Store, data_set_id: string, view: RememberedView): void {
  const text = (scene: Scene | null) => (scene ? scene_to_json(scene) : null);
  try {
    store.setItem(key_of(data_set_id), JSON.stringify({ ...view, scene: text(view.scene), begun: text(view.begun) }));
  } catch {
    // Full, or not allowed: after a reload the picture begins anew.
  }
}
