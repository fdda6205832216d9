import { create } from "@bufbuild/protobuf";
import { beforeEach, describe, expect, it } from "vitest";
import type { ScanTour } from "../api/studies";
import { orbitOf, type CameraPose } from "../input/camera";
import { turnBetween } from "../input/camera_path";
import { vec3 } from "../input/vec3";
import { PresetSchema } from "../protocol/gen/api/proto/scene_pb";
import { ConfigSchema, GoodViewsSchema } from "../protocol/gen/api/proto/stream_pb";
import { cameraOf, type Scene } from "../protocol/messages";
import { someScene } from "../scene/testing";
import { CameraMotion } from "./camera_motion";
import { SceneEditor } from "./scene_editor";
import { Tour } from "./tour";

/** Returns a value that the test has put there. */
function sure<Value>(value: Value | null | undefined): Value {
  if (value === null || value === undefined) throw new Error("The value is missing.");
  return value;
}

const goodViews = create(GoodViewsSchema, {
  views: [-180, -120, -60, 0, 60, 120].map((azimuth) => ({ azimuth, elevation: 5, entropy: 9 })),
  low: { x: -80, y: -90, z: -100 },
  high: { x: 80, y: 90, z: 100 },
});

let leads: boolean;
let calm: boolean;
let nowMs: number;
let frames: (() => void)[];
let sent: Scene[];
let rests: number;
let shownInput: number;
let editor: SceneEditor;
let motion: CameraMotion;
let tour: Tour;
let asked: number;
let loadStudy: () => Promise<ScanTour | null>;
let shape: { width: number; height: number };

beforeEach(() => {
  [leads, calm, nowMs, frames, sent, rests, shownInput] = [true, false, 0, [], [], 0, 0];
  shape = { width: 400, height: 300 };
  asked = 0;
  loadStudy = () => Promise.resolve(null);
  editor = new SceneEditor({
    leads: () => leads,
    canvasSize: () => shape,
    send: (scene) => sent.push(scene),
    rest: () => (rests += 1),
  });
  const scene = someScene();
  editor.configured(create(ConfigSchema, { scene, presets: [create(PresetSchema, { name: "bone", scene })] }), true);
  motion = new CameraMotion({
    editor,
    nextFrame: (task) => frames.push(task),
    nowMs: () => nowMs,
    isCalm: () => calm,
  });
  tour = new Tour({
    editor,
    motion,
    loadStudy: () => loadStudy(),
    isConnected: () => true,
    ask: () => {
      asked += 1;
      return true;
    },
    leads: () => leads,
    aspect: () => shape.width / shape.height,
    sentInput: () => sent.length,
    shownInput: () => shownInput,
    after: () => () => undefined,
    isCalm: () => calm,
  });
});

/** Lets time pass in frames of the screen. Pictures are `late` inputs behind. */
function pass(count: number, ms = 16, late = 2): void {
  for (let i = 0; i < count; ++i) {
    nowMs += ms;
    shownInput = Math.max(shownInput, sent.length - late);
    for (const task of frames.splice(0)) task();
  }
}

const start = async (views = goodViews) => {
  const started = tour.toggle();
  await askedTheWorker();
  tour.receive(views);
  await started;
};
/** The worker is asked once it is known that there is no tour of a study. */
async function askedTheWorker(): Promise<void> {
  await tour.loadStudy();
  await Promise.resolve();
}
const pose = (): CameraPose => sure(cameraOf(sure(editor.scene.value)));
const turns = (scenes: readonly Scene[]) =>
  scenes
    .slice(1)
    .map((scene, i) => turnBetween(orbitOf(sure(cameraOf(sure(scenes[i])))), orbitOf(sure(cameraOf(scene)))));

describe("Show me around", () => {
  it("turns once around and comes to rest, as one undo step", async () => {
    const before = pose();
    await start();
    expect(tour.state.value).toBe("moving");
    pass(5000);
    expect(tour.state.value).toBe("off");
    expect(rests).toBe(1);
    expect(Math.max(...turns(sent))).toBeLessThanOrEqual(3);
    expect(turns(sent).reduce((sum, turn) => sum + turn)).toBeGreaterThan(340); // 360 degrees seen from a little above
    editor.undo();
    expect(pose()).toEqual(before);
  });
  it("waits for the picture, so that no two shown pictures are more than 3 degrees apart", async () => {
    await start();
    let last = sent.length;
    const shown: Scene[] = [];
    for (let picture = 0; picture < 60; ++picture) {
      pass(40, 16, Infinity); // a slow server: 40 refreshes of the screen without a picture
      shownInput = sent.length;
      expect(sent.length).toBeGreaterThan(last);
      last = sent.length;
      shown.push(sure(sent.at(-1)));
    }
    expect(Math.max(...turns(shown))).toBeLessThanOrEqual(3 + 1e-6);
  });
  it("pauses, and continues from there", async () => {
    await start();
    pass(100);
    tour.pauseOrContinue();
    expect([tour.state.value, rests]).toEqual(["paused", 1]);
    const [paused, count] = [pose(), sent.length];
    pass(100);
    expect(sent.length).toBe(count);
    tour.pauseOrContinue();
    pass(1);
    expect(turnBetween(orbitOf(paused), orbitOf(pose()))).toBeLessThan(1);
    pass(5000);
    expect(tour.state.value).toBe("off");
  });
  it("stops by any gesture, moving or paused, and leaves the camera there", async () => {
    for (const paused of [false, true]) {
      await start();
      pass(100);
      if (paused) tour.pauseOrContinue();
      editor.act({ kind: "rotate", right: 0.2, down: 0 });
      const after = pose();
      expect(tour.state.value).toBe("off");
      pass(100);
      expect(pose()).toEqual(after);
    }
  });
  it("continues after the window has changed its shape, at the distance of that shape", async () => {
    await start();
    pass(1000);
    const before = orbitOf(pose()).distance;
    motion.during(() =>
      tour.during(() => {
        shape = { width: 300, height: 600 };
        editor.resized({ width: 400, height: 300 }, shape);
      }),
    );
    expect(tour.state.value).toBe("moving");
    pass(10);
    expect(orbitOf(pose()).distance / before).toBeCloseTo(2, 2); // the picture is half as wide as it is high
    expect(tour.state.value).toBe("moving");
  });
  it("ends when anything but the camera changes, with two undo steps", async () => {
    await start();
    pass(100);
    editor.change("density", (scene) => ({ ...scene, bounces: 3 }), true);
    pass(100);
    expect(tour.state.value).toBe("off");
    expect(editor.steps.value.past.length).toBe(2);
  });
  it("ignores the answer to a stopped request, without a message", async () => {
    const first = tour.toggle();
    await askedTheWorker();
    tour.stop();
    const second = tour.toggle();
    await askedTheWorker();
    await first;
    expect([tour.state.value, tour.fault.value]).toEqual(["asking", null]);
    tour.receive(goodViews);
    await second;
    expect(tour.state.value).toBe("moving");
  });
  it("stops when somebody else presents, and starts only for the presenter", async () => {
    await start();
    pass(10);
    leads = false;
    pass(10);
    expect(tour.state.value).toBe("off");
    await tour.toggle();
    expect(tour.state.value).toBe("off");
  });
  it("says why there is none", async () => {
    await start(create(GoodViewsSchema));
    expect([tour.state.value, tour.fault.value]).toEqual(["off", "nothing"]);
    const started = tour.toggle();
    await askedTheWorker();
    tour.receive(null);
    await started;
    expect([tour.state.value, tour.fault.value]).toEqual(["off", "unanswered"]);
  });
  it("can be stopped before the answer", async () => {
    const started = tour.toggle();
    await askedTheWorker();
    await tour.toggle();
    tour.receive(goodViews);
    await started;
    pass(10);
    expect([tour.state.value, sent.length]).toEqual(["off", 0]);
  });
  it("shows still views to users who prefer reduced motion", async () => {
    calm = true;
    await start();
    pass(60_000 / 16);
    expect(sent.length).toBeLessThanOrEqual(9);
    expect(sent.length).toBeGreaterThanOrEqual(7);
    expect(tour.state.value).toBe("off");
  });
  it("has 16 key views for a video", async () => {
    const scenes = tour.videoScenes(sure(editor.scene.value));
    await askedTheWorker();
    tour.receive(goodViews);
    const keys = await scenes;
    expect(keys).toHaveLength(16);
    expect(keys?.map(({ lights }) => lights)).toEqual(Array(16).fill(editor.scene.value?.lights));
  });
});

describe("the way to a side", () => {
  const side = { eye: vec3(900, 0, 0), target: vec3(0, 0, 0), up: vec3(0, 0, 1), verticalFovDegrees: 30 };
  it("takes time, ends exactly there and is one undo step", () => {
    const before = pose();
    motion.flyTo(side, "side L");
    pass(3);
    expect(turnBetween(orbitOf(pose()), orbitOf(side))).toBeGreaterThan(5);
    pass(100);
    expect(pose()).toEqual(side);
    expect(rests).toBe(1);
    editor.undo();
    expect(pose()).toEqual(before);
  });
  it("is a jump for users who prefer reduced motion", () => {
    calm = true;
    motion.flyTo(side, "side L");
    expect(pose()).toEqual(side);
  });
  it("ends with a gesture", () => {
    motion.flyTo(side, "side L");
    pass(3);
    editor.act({ kind: "zoom", factor: 1.1 });
    const after = pose();
    pass(100);
    expect(pose()).toEqual(after);
  });
});

const studyTour: ScanTour = {
  views: [
    { eye: [0, -500, 0], target: [0, 0, 0], up: [0, 0, 1] },
    { eye: [450, 0, 10], target: [0, 0, 10], up: [0, 0, 1] },
    { eye: [0, 400, 100], target: [0, 0, 20], up: [0, 0, 1] },
  ],
  participants: 12,
  title: { en: "Views" },
  removable: true,
};
const isAt = (scene: Scene, [x, y, z]: readonly [number, number, number]) => {
  const { eye } = sure(cameraOf(scene));
  return Math.hypot(eye.x - x, eye.y - y, eye.z - z) < 3; // between two refreshes near a stop, the eye moves less
};

describe("A tour through the views of a study", () => {
  beforeEach(() => {
    loadStudy = () => Promise.resolve(studyTour);
  });
  it("passes all views in order, and asks the worker for none", async () => {
    await tour.toggle();
    expect([tour.state.value, asked]).toEqual(["moving", 0]);
    pass(8000);
    expect(tour.state.value).toBe("off");
    const passed = studyTour.views.map(({ eye }) => sent.findIndex((scene) => isAt(scene, eye)));
    expect(passed).not.toContain(-1);
    expect(passed).toEqual([...passed].sort((a, b) => a - b));
    const first = passed[0] ?? 0;
    expect(isAt(sure(sent.at(-1)), studyTour.views[0]?.eye ?? [0, 0, 0])).toBe(true);
    expect(first).toBeLessThan(sent.length - 1);
    expect(Math.max(...turns(sent))).toBeLessThanOrEqual(3);
  });
  it("shows just these views to those who prefer reduced motion", async () => {
    calm = true;
    await tour.toggle();
    pass(1, 0);
    for (let view = 0; view < 5; ++view) pass(1, 4000);
    const rests = [...studyTour.views, ...studyTour.views.slice(0, 1)];
    expect(sent.length).toBe(rests.length);
    expect(rests.map(({ eye }, i) => isAt(sure(sent[i]), eye))).toEqual(rests.map(() => true));
  });
  it("makes its video", async () => {
    const scenes = sure(await tour.videoScenes(sure(editor.scene.value)));
    expect(scenes.length).toBeGreaterThan(2);
    expect([scenes[0], scenes.at(-1)].map((scene) => isAt(sure(scene), [0, -500, 0]))).toEqual([true, true]);
  });
  it("uses computed views if the study's can't be loaded, and tries again", async () => {
    let attempts = 0;
    loadStudy = () => (++attempts === 1 ? Promise.reject(new Error("offline")) : Promise.resolve(studyTour));
    await start();
    expect([tour.state.value, asked]).toEqual(["moving", 1]);
    tour.stop();
    await tour.toggle();
    await tour.loadStudy();
    expect([attempts, asked]).toEqual([2, 1]);
  });
  it("uses computed views once the owner removed the study's", async () => {
    await tour.loadStudy();
    tour.forgetStudy();
    await start();
    expect([tour.study.value, asked]).toEqual([null, 1]);
  });
  it("does not start if it was stopped while it was loading", async () => {
    const started = tour.toggle();
    await tour.toggle();
    await started;
    expect([tour.state.value, asked, sent.length]).toEqual(["off", 0, 0]);
  });
});
