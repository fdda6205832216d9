import { create } from "@bufbuild/protobuf";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { PresetSchema } from "../protocol/gen/api/proto/scene_pb";
import { ConfigSchema } from "../protocol/gen/api/proto/stream_pb";
import { cameraOf, withCamera } from "../protocol/messages";
import { length, subtract, vec3 } from "../input/vec3";
import { someScene } from "../scene/testing";
import { GuidedCamera } from "./guided_camera";
import { SceneEditor } from "./scene_editor";

let role: { leads: boolean; presents: boolean; connected: boolean };
let waits: (() => void)[];
let asked: number;
let editor: SceneEditor;
let guide: GuidedCamera;

beforeEach(() => {
  vi.stubGlobal("matchMedia", () => ({ matches: true })); // prefers reduced motion, so that a flight takes one step
  vi.stubGlobal("requestAnimationFrame", () => 0);
  role = { leads: true, presents: true, connected: true };
  [waits, asked] = [[], 0];
  const canvasSize = () => ({ width: 400, height: 300 });
  editor = new SceneEditor({ leads: () => role.leads, canvasSize, send: () => undefined, rest: () => undefined });
  const scene = someScene();
  editor.configured(create(ConfigSchema, { scene, presets: [create(PresetSchema, { name: "bone", scene })] }), true);
  guide = new GuidedCamera({
    editor,
    leads: () => role.leads,
    presents: () => role.presents,
    canvasSize,
    loadStudy: () => Promise.resolve(null),
    isConnected: () => role.connected,
    askForViews: () => {
      asked += 1;
      return role.connected;
    },
    sentInput: () => 0,
    shownInput: () => 0,
    after: (_, task) => {
      waits.push(task);
      return () => (waits = waits.filter((one) => one !== task));
    },
  });
});
afterEach(() => {
  guide.close();
  vi.unstubAllGlobals();
});

const pose = () => {
  const found = editor.scene.value && cameraOf(editor.scene.value);
  if (!found) throw new Error("There is no camera.");
  return found;
};
const distance = () => length(subtract(pose().eye, pose().target));

describe("a tour", () => {
  it("is not offered to a follower, nor to one with a free camera", async () => {
    for (const leads of [false, true]) {
      Object.assign(role, { leads, presents: false });
      await guide.tour.toggle();
      expect([guide.tour.state.value, asked]).toEqual(["off", 0]);
    }
  });
  it("says that an old worker, which knows no such request, has found no views", async () => {
    const started = guide.tour.toggle();
    await vi.waitUntil(() => waits.length > 0);
    for (const task of waits) task();
    await started;
    expect([guide.tour.state.value, guide.tour.fault.value]).toEqual(["off", "unanswered"]);
  });
  it("says that there is no connection, before the request and after it", async () => {
    role.connected = false;
    await guide.tour.toggle();
    expect([asked, guide.tour.fault.value]).toEqual([1, "disconnected"]);
    role.connected = true;
    const started = guide.tour.toggle();
    await vi.waitUntil(() => waits.length > 0);
    role.connected = false;
    for (const task of waits) task();
    await started;
    expect(guide.tour.fault.value).toBe("disconnected");
  });
});

describe("a side of the patient", () => {
  const look = { eye: vec3(30, -200, 10), target: vec3(30, 0, 10), up: vec3(0, 0, 1), verticalFovDegrees: 55 };
  it("keeps the place, the zoom and the lens when the cube is pressed", () => {
    editor.change("lens", (scene) => withCamera(scene, look), true);
    guide.turnTo("L");
    expect([distance(), pose().target, pose().verticalFovDegrees]).toEqual([200, look.target, 55]);
    expect(pose().eye).toEqual(vec3(230, 0, 10));
  });
  it("is framed as at the start by a button or key", () => {
    const before = distance();
    editor.change("lens", (scene) => withCamera(scene, look), true);
    guide.viewFrom("L");
    expect(distance()).toBeCloseTo(before);
  });
  it("is for a follower with a free camera, and no other", () => {
    Object.assign(role, { leads: false, presents: false });
    const before = pose();
    guide.turnTo("L");
    expect(pose()).toEqual(before);
    role.leads = true;
    guide.turnTo("L");
    expect(pose()).not.toEqual(before);
  });
});
