import { beforeEach, expect, it } from "vitest";
import type { Config, Scene } from "../protocol/messages";
import { PhaseKind } from "../scene/phases";
import { someScene } from "../scene/testing";
import { PhasePlayer } from "./phase_player";
import { SceneEditor } from "./scene_editor";

let now = 0;
let frames: (() => void)[] = [];
let leads = true;
let sent: number[] = [];
let rests = 0;

function player(count = 10): { readonly phases: PhasePlayer; readonly editor: SceneEditor } {
  const editor = new SceneEditor({
    leads: () => leads,
    canvasSize: () => ({ width: 800, height: 600 }),
    send: (scene) => sent.push(scene.volumePhase),
    rest: () => (rests += 1),
  });
  editor.configured({ presets: [], scene: someScene() } as unknown as Config, false);
  sent = [];
  const phases = new PhasePlayer({
    editor,
    leads: () => leads,
    nextFrame: (task) => frames.push(task),
    nowMs: () => now,
  });
  phases.configured(Array.from({ length: count }, (_, i) => ({ kind: PhaseKind.CYCLE, value: (100 * i) / count })));
  return { phases, editor };
}

/** Lets the screen refresh after some time. */
function refresh(ms: number): void {
  now += ms;
  for (const task of frames.splice(0)) task();
}

beforeEach(() => {
  now = 0;
  frames = [];
  leads = true;
  sent = [];
  rests = 0;
});

it("plays only after a request, sends each phase once, and rests when it is paused", () => {
  const { phases } = player();
  refresh(1000);
  expect(sent).toEqual([]);
  phases.toggle();
  for (let i = 0; i < 12; i++) refresh(50); // two refreshes per phase
  expect(sent).toEqual([1, 2, 3, 4, 5, 6]);
  phases.toggle();
  refresh(500);
  expect(sent).toEqual([1, 2, 3, 4, 5, 6]);
  expect(rests).toBe(1);
});

it("keeps the speed when the screen refreshes seldom", () => {
  const { phases } = player();
  phases.toggle();
  refresh(370);
  refresh(370);
  expect(sent).toEqual([3, 7]);
});

it("changes the speed from the current phase on", () => {
  const { phases } = player();
  phases.toggle();
  refresh(300);
  phases.setRate(5);
  refresh(200);
  expect(sent).toEqual([3, 4]);
});

it("stops at the last phase without repetition, and begins again from the first", () => {
  const { phases, editor } = player();
  phases.repeats.value = false;
  phases.toggle();
  refresh(5000);
  expect(phases.playing.value).toBe(false);
  expect(editor.scene.value?.volumePhase).toBe(9);
  phases.toggle();
  refresh(100);
  expect(sent).toEqual([9, 0, 1]);
});

it("makes no undo steps, and undoing an edit keeps the phase", () => {
  const { phases, editor } = player();
  const dimmed = (scene: Scene): Scene => ({ ...scene, bounces: 4 });
  editor.change("bounces", dimmed);
  phases.toggle();
  for (let i = 0; i < 5; i++) refresh(100);
  phases.toggle();
  expect(editor.steps.value.past).toHaveLength(1);
  editor.undo();
  expect(editor.scene.value).toMatchObject({ bounces: someScene().bounces, volumePhase: 5 });
});

it("choosing a phase ends playing", () => {
  const { phases } = player();
  phases.toggle();
  refresh(100);
  phases.choose(7, true);
  refresh(100);
  expect(sent).toEqual([1, 7]);
  expect(rests).toBe(0);
  phases.step(1);
  phases.choose(9);
  phases.step(1);
  expect(sent).toEqual([1, 7, 8, 9, 0]);
});

it("stops when another participant presents, and a follower cannot choose", () => {
  const { phases } = player();
  phases.toggle();
  leads = false;
  refresh(100);
  phases.choose(3);
  phases.toggle();
  refresh(100);
  expect([phases.playing.value, sent]).toEqual([false, []]);
});

it("a scan without phases plays nothing", () => {
  const { phases } = player(0);
  phases.toggle();
  phases.choose(1);
  phases.step(1);
  expect([phases.playing.value, sent, frames.length]).toEqual([false, [], 0]);
});
