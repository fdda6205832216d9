import { describe, expect, it } from "vitest";
import type { Scene } from "../../../protocol/gen/api/proto/scene_pb";
import { someScene } from "../../../scene/testing";
import { channelsOf } from "../../../scene/transfer";
import { clampedSelection, transferEdits, type Selection } from "./transfer_edits";

class FakeEditor {
  scene = someScene();
  changes: string[] = [];
  rests = 0;
  change(what: string, edit: (scene: Scene) => Scene, held = false): void {
    this.changes.push(held ? `${what} (held)` : what);
    this.scene = edit(this.scene);
  }
  rest(): void {
    this.rests += 1;
  }
}

function editsAt(selected: Selection) {
  const editor = new FakeEditor();
  const selections: Selection[] = [];
  const edits = transferEdits(editor, editor.scene, selected, (next) => selections.push(next));
  const points = () => channelsOf(editor.scene)[selected.channel]?.opacity.map(({ value }) => value);
  return { editor, edits, selections, points };
}

describe("clampedSelection", () => {
  it("keeps a selection that exists, and limits one that no longer does", () => {
    const channels = channelsOf(someScene());
    expect(clampedSelection(channels, { channel: 1, point: 2 })).toEqual({ channel: 1, point: 2 });
    expect(clampedSelection(channels, { channel: 9, point: 9 })).toEqual({ channel: 1, point: 2 });
  });
});

describe("transferEdits", () => {
  it("selects a point that was added, wherever it lies among the others", () => {
    const { editor, edits, selections, points } = editsAt({ channel: 0, point: 0 });
    edits.addPoint({ value: 100, opacity: 0.5 });
    expect(points()).toEqual([5, 55, 100, 260]);
    expect(selections).toEqual([{ channel: 0, point: 2 }]);
    expect(editor.rests).toBe(1);
  });

  it("adds a point without a position where there is most room", () => {
    const { edits, points } = editsAt({ channel: 0, point: 0 });
    edits.addPoint();
    expect(points()).toEqual([5, 55, 158, 260]);
  });

  it("selects the point before one that was removed", () => {
    const { edits, selections, points } = editsAt({ channel: 0, point: 1 });
    edits.removePoint();
    expect(points()).toEqual([5, 260]);
    expect(selections).toEqual([{ channel: 0, point: 0 }]);
  });

  it("moves a point as one held change, so that a drag is one undo step", () => {
    const { editor, edits, points } = editsAt({ channel: 0, point: 1 });
    edits.movePoint(1, 60, 0.5, true);
    expect(points()).toEqual([5, 60, 260]);
    expect(editor.changes).toEqual(["point 0 1 (held)"]);
    expect(editor.rests).toBe(0);
  });

  it("selects the second point of a new channel", () => {
    const { editor, edits, selections } = editsAt({ channel: 0, point: 0 });
    edits.addChannel("new", { low: 0, high: 100 });
    expect(channelsOf(editor.scene)).toHaveLength(3);
    expect(selections).toEqual([{ channel: 2, point: 1 }]);
  });

  it("hides a channel", () => {
    const { editor, edits } = editsAt({ channel: 0, point: 0 });
    edits.showChannel(1, false);
    expect(channelsOf(editor.scene).map(({ disabled }) => disabled)).toEqual([false, true]);
  });
});
