import type { Scene } from "../../../protocol/gen/api/proto/scene_pb";
import type { SceneEditor } from "../../../video/scene_editor";
import type { Changed } from "./controls";

export type Editor = Pick<SceneEditor, "change" | "rest">;

export interface SceneEdits {
  /** Ends the current undo step. */
  readonly rest: () => void;
  /** Returns the handler of a control that can be held, such as a slider. The control calls `rest` at the end. */
  readonly live: <Value>(what: string, edit: (before: Scene, value: Value) => Scene) => Changed<Value>;
  /** Returns the handler of a control that changes in one step, such as a switch. */
  readonly once: <Value>(what: string, edit: (before: Scene, value: Value) => Scene) => (value: Value) => void;
  /** Applies one complete change. */
  readonly apply: (what: string, edit: (before: Scene) => Scene) => void;
}

/** Handlers for the controls of a window. `what` names the change, so that one drag becomes one undo step. */
export function sceneEdits(editor: Editor): SceneEdits {
  const rest = () => editor.rest();
  const apply = (what: string, edit: (before: Scene) => Scene) => {
    editor.change(what, edit);
    rest();
  };
  return {
    rest,
    apply,
    live: (what, edit) => (value, held) => editor.change(what, (before) => edit(before, value), held),
    once: (what, edit) => (value) => apply(what, (before) => edit(before, value)),
  };
}
