import { create } from "@bufbuild/protobuf";
import { beforeEach, describe, expect, it } from "vitest";
import { vec3, type Vec3 } from "../input/vec3";
import { PhaseSchema, PresetSchema, SceneSchema } from "../protocol/gen/api/proto/scene_pb";
import { ConfigSchema } from "../protocol/gen/api/proto/stream_pb";
import { cameraOf, withCamera, withClip, type Preset, type Scene } from "../protocol/messages";
import { setOpacity, setShown, unlabelled } from "../scene/labels";
import { setExposure } from "../scene/lens";
import { someScene } from "../scene/testing";
import { rgbOf } from "../scene/colour";
import { setDensity, transferOf } from "../scene/transfer";
import { SceneEditor } from "./scene_editor";

const preset = (name: string, scene: Scene = someScene()): Preset => create(PresetSchema, { name, scene });
const denser = (extinctionPerMm: number) => (scene: Scene) => setDensity(scene, extinctionPerMm);
const seenFrom = (eye: Vec3) => (scene: Scene) => {
  const pose = cameraOf(scene);
  return pose ? withCamera(scene, { ...pose, eye }) : scene;
};
const density = (editor: SceneEditor) => editor.scene.value?.transferFunction?.extinctionPerMm;
const orbit = { kind: "rotate", right: 0.3, down: 0 } as const;

let leads: boolean;
let size: { width: number; height: number };
let sent: { scene: Scene; rest: boolean }[];
let rests: number;
let editor: SceneEditor;

/** The server's first configuration of a session that nobody has edited yet. */
const begin = (scene = someScene(), presets: Preset[] = [preset("bone")]) =>
  editor.configured(create(ConfigSchema, { scene, presets }), true);

beforeEach(() => {
  leads = true;
  size = { width: 400, height: 300 };
  sent = [];
  rests = 0;
  editor = new SceneEditor({
    leads: () => leads,
    canvasSize: () => size,
    send: (scene, rest) => sent.push({ scene, rest }),
    rest: () => (rests += 1),
  });
});

describe("a session that begins with another scene than the server's", () => {
  const other = seenFrom(vec3(300, 0, 0))(someScene());
  const eyeOf = (scene: Scene | null | undefined) => scene && cameraOf(scene)?.eye;
  const parts = () => ({
    leads: () => leads,
    canvasSize: () => size,
    send: (scene: Scene, rest: boolean) => sent.push({ scene, rest }),
    rest: () => undefined,
  });

  it("sends it before anything is shown, and resets the camera to it", () => {
    const begun = new SceneEditor({ ...parts(), firstScene: () => other });
    const config = create(ConfigSchema, { scene: someScene(), presets: [preset("bone")] });
    expect(begun.configured(config, true)).toBe(true);
    expect(eyeOf(sent.at(-1)?.scene)).toEqual(eyeOf(other));
    begun.act(orbit);
    begun.resetCamera();
    expect(eyeOf(begun.scene.value)).toEqual(eyeOf(other));
  });

  it("keeps what the user has changed since, after a reconnection", () => {
    const begun = new SceneEditor({ ...parts(), firstScene: () => other });
    const config = create(ConfigSchema, { scene: someScene(), presets: [] });
    expect(begun.configured(config, false)).toBe(false);
    expect(sent).toEqual([]);
  });
});

describe("SceneEditor.configured", () => {
  it("takes the scene and the presets without sending anything back", () => {
    begin();
    expect(density(editor)).toBe(1.1);
    expect(editor.presets.value.map(({ name }) => name)).toEqual(["bone"]);
    expect(editor.begun.value).toBe(editor.scene.value);
    expect(sent).toEqual([]);
  });

  it("moves the camera back in an upright window, so that the whole volume is seen", () => {
    size = { width: 200, height: 400 };
    begin();
    expect(sent).toHaveLength(1);
    expect(cameraOf(sent[0]?.scene ?? someScene())?.eye.y).toBeLessThan(-500);
    expect(editor.steps.value.past).toEqual([]);
  });

  it("moves the camera back when the window becomes upright, without a step to undo", () => {
    begin();
    const eye = () => cameraOf(editor.scene.value ?? someScene())?.eye.y ?? 0;
    const before = eye();
    editor.resized({ width: 400, height: 300 }, { width: 200, height: 400 });
    expect(eye()).toBeCloseTo(2 * before, 6);
    editor.resized({ width: 200, height: 400 }, { width: 400, height: 300 });
    expect(eye()).toBeCloseTo(before, 6);
    expect(editor.steps.value.past).toEqual([]);
    leads = false;
    editor.resized({ width: 400, height: 300 }, { width: 200, height: 400 });
    expect(eye()).toBeCloseTo(before, 6);
  });

  it("moves the undo steps back as well when the window becomes upright", () => {
    begin();
    editor.change("density", denser(2));
    const eye = () => cameraOf(editor.scene.value ?? someScene())?.eye.y ?? 0;
    const before = eye();
    editor.resized({ width: 400, height: 300 }, { width: 200, height: 400 });
    editor.undo();
    expect(density(editor)).toBe(1.1);
    expect(eye()).toBeCloseTo(2 * before, 6);
  });

  it("keeps the undo steps when a reconnection brings the same scene", () => {
    begin();
    editor.change("density", denser(2));
    const now = editor.scene.value ?? someScene();
    editor.configured(create(ConfigSchema, { scene: create(SceneSchema, now) }), false);
    expect(editor.steps.value.past).toHaveLength(1);
  });

  it("keeps the undo steps of a scene that was stored as JSON, which has no -0", () => {
    const at = (x: number): Scene => ({ ...someScene(), phase: create(PhaseSchema, { g: x }) });
    begin(at(0));
    editor.change("density", denser(2));
    editor.configured(create(ConfigSchema, { scene: denser(2)(at(-0)) }), false);
    expect(editor.steps.value.past).toHaveLength(1);
  });

  it("forgets the undo steps when the scene was changed elsewhere", () => {
    begin();
    editor.change("density", denser(2));
    editor.configured(create(ConfigSchema, { scene: denser(7)(someScene()) }), false);
    expect(editor.steps.value.past).toEqual([]);
    expect(density(editor)).toBe(7);
  });

  it("does not replace the first scene of an edited session", () => {
    begin();
    const first = editor.begun.value;
    editor.configured(create(ConfigSchema, { scene: denser(7)(someScene()) }), false);
    expect(editor.begun.value).toBe(first);
  });
});

describe("SceneEditor.change", () => {
  it("sends the edited scene and remembers one undo step", () => {
    begin();
    editor.change("density", denser(2));
    expect(density(editor)).toBe(2);
    expect(sent.map(({ scene, rest }) => [scene.transferFunction?.extinctionPerMm, rest])).toEqual([[2, false]]);
    expect(editor.steps.value.past).toHaveLength(1);
  });

  it("combines all edits of a drag into one step", () => {
    begin();
    for (const value of [2, 3, 4]) editor.change("density", denser(value), true);
    editor.rest();
    editor.change("density", denser(5), true);
    expect(editor.steps.value.past).toHaveLength(2);
    expect(rests).toBe(1);
    editor.undo();
    expect(density(editor)).toBe(4);
    editor.undo();
    expect(density(editor)).toBe(1.1);
  });

  it("sends nothing when the edit changes nothing", () => {
    begin();
    editor.change("density", (scene) => scene);
    expect(sent).toEqual([]);
    expect(editor.steps.value.past).toEqual([]);
  });

  it("changes nothing for a follower", () => {
    begin();
    leads = false;
    editor.change("density", denser(2));
    editor.act(orbit);
    editor.undo();
    expect(sent).toEqual([]);
    expect(density(editor)).toBe(1.1);
  });

  it("keeps the undo steps of a follower, who may lead again", () => {
    begin();
    editor.change("density", denser(2));
    leads = false;
    editor.undo();
    expect(editor.steps.value.past).toHaveLength(1);
    leads = true;
    editor.undo();
    expect(density(editor)).toBe(1.1);
  });

  it("does nothing before there is a scene", () => {
    editor.change("density", denser(2));
    editor.act(orbit);
    editor.undo();
    editor.resetCamera();
    expect(sent).toEqual([]);
    expect(editor.scene.value).toBeNull();
  });
});

describe("undo and redo", () => {
  it("go back and forth, and send each scene as a finished one", () => {
    begin();
    editor.change("density", denser(2));
    editor.undo();
    expect(density(editor)).toBe(1.1);
    editor.redo();
    expect(density(editor)).toBe(2);
    expect(sent.map(({ rest }) => rest)).toEqual([false, true, true]);
  });

  it("discard the undone steps after a new edit", () => {
    begin();
    editor.change("density", denser(2));
    editor.undo();
    editor.change("exposure", (scene) => setExposure(scene, 1));
    editor.redo();
    expect(density(editor)).toBe(1.1);
  });

  it("stop at the first step", () => {
    begin();
    editor.undo();
    expect(sent).toEqual([]);
  });
});

describe("the camera", () => {
  it("moves with a gesture, and can be reset to the start of the session", () => {
    begin();
    const first = editor.scene.value && cameraOf(editor.scene.value);
    editor.act(orbit);
    expect(editor.scene.value && cameraOf(editor.scene.value)?.eye).not.toEqual(first?.eye);
    editor.resetCamera();
    expect(editor.scene.value && cameraOf(editor.scene.value)?.eye).toEqual(first?.eye);
    expect(sent.at(-1)?.rest).toBe(true);
  });
});

describe("presets", () => {
  const glass = () => preset("glass", denser(9)(someScene()));

  it("change the look and keep the camera, the clip and the labels", () => {
    begin(someScene(), [preset("bone"), glass()]);
    editor.act(orbit);
    editor.change("clip", (scene) => withClip(scene, { low: [0, 0, 0], high: [9, 9, 9] }, []));
    editor.change("label", (scene) => setShown(scene, 3, false));
    const before = editor.scene.value;
    editor.applyPreset(glass());
    expect(density(editor)).toBe(9);
    expect(editor.scene.value?.labels).toEqual(before?.labels);
    expect(editor.scene.value?.camera).toEqual(before?.camera);
    expect(editor.scene.value?.clip).toEqual(before?.clip);
    editor.undo();
    expect(density(editor)).toBe(1.1);
  });

  it("bring their own camera until somebody moves it", () => {
    const near = () => preset("brain", seenFrom(vec3(0, -50, 0))(denser(7)(someScene())));
    begin(someScene(), [preset("bone"), near()]);
    editor.applyPreset(near());
    expect(editor.scene.value && cameraOf(editor.scene.value)?.eye).toEqual(vec3(0, -50, 0));
    editor.applyPreset(preset("bone"));
    editor.act(orbit);
    const moved = editor.scene.value?.camera;
    editor.applyPreset(near());
    expect(editor.scene.value?.camera).toEqual(moved);
  });

  it("bring their own camera also after the window was resized", () => {
    const near = seenFrom(vec3(0, -50, 0))(denser(7)(someScene()));
    begin(someScene(), [preset("bone"), preset("brain", near)]);
    for (const next of [
      { width: 210, height: 370 },
      { width: 170, height: 390 },
    ]) {
      const before = size;
      size = next;
      editor.resized(before, next);
    }
    editor.applyPreset(preset("brain", near));
    expect(editor.scene.value && cameraOf(editor.scene.value)).toEqual(cameraOf(editor.framed(near)));
  });

  it("show and hide what they need, but leave what the user has changed", () => {
    const alone = preset("brain", setShown(denser(7)(someScene()), unlabelled, false));
    begin(someScene(), [preset("bone"), alone]);
    editor.applyPreset(alone);
    expect(editor.scene.value?.labels).toMatchObject([{ number: unlabelled, opacity: 0 }]);
    editor.change("label", (scene) => setShown(scene, 3, false));
    editor.applyPreset(preset("bone"));
    expect(editor.scene.value?.labels).toMatchObject([{ number: 3, opacity: 0 }]);
    editor.change("label", (scene) => setOpacity(scene, unlabelled, 0.5));
    editor.applyPreset(alone);
    expect(editor.scene.value?.labels.map(({ number, opacity }) => [number, opacity])).toEqual([
      [unlabelled, 0.5],
      [3, 0],
    ]);
  });

  it("show what another one hides, also after its materials were edited", () => {
    const alone = preset("brain", setShown(denser(7)(someScene()), unlabelled, false));
    begin(someScene(), [preset("bone"), alone]);
    editor.applyPreset(alone);
    editor.change("density", denser(3));
    expect(editor.activePreset()).toBeNull();
    editor.applyPreset(preset("bone"));
    expect(editor.scene.value?.labels).toEqual([]);
  });

  it("are active if the scene has their look, from any camera", () => {
    begin(someScene(), [preset("bone"), glass()]);
    editor.act(orbit);
    expect(editor.activePreset()?.name).toBe("bone");
    editor.applyPreset(glass());
    expect(editor.activePreset()?.name).toBe("glass");
    editor.change("density", denser(3));
    expect(editor.activePreset()).toBeNull();
  });

  it("start with their own camera by beginWith, which is not an undo step", () => {
    begin();
    editor.act(orbit);
    const steps = editor.steps.value.past.length;
    editor.beginWith(glass());
    expect(editor.scene.value && cameraOf(editor.scene.value)?.eye).toEqual({ x: 0, y: -500, z: 60 });
    expect(editor.steps.value.past).toHaveLength(steps);
  });
});

describe("A saved scene", () => {
  const upright = { width: 200, height: 400 };
  const eye = (scene: Scene | null) => cameraOf(scene ?? someScene())?.eye.y;

  it("is shown from farther away in an upright window, and saved as it was", () => {
    begin();
    size = upright;
    editor.showScene(someScene());
    expect(eye(editor.scene.value)).toBeCloseTo(-1000, 6);
    expect(eye(editor.toSave())).toBeCloseTo(-500, 6);
  });

  it("is the shown one in a wide window", () => {
    begin();
    editor.showScene(someScene());
    expect(eye(editor.scene.value)).toBe(-500);
    expect(editor.toSave()).toBe(editor.scene.value);
  });
});

describe("reset, replace and cutScene", () => {
  it("reset returns one part to what the session began with", () => {
    begin();
    editor.change("density", denser(2));
    editor.change("exposure", (scene) => setExposure(scene, 1));
    editor.reset("look");
    expect(density(editor)).toBe(1.1);
    expect(editor.scene.value?.display?.exposure).toBe(1);
  });

  it("replace shows another person's scene without sending it, and forgets the steps", () => {
    begin();
    editor.change("density", denser(2));
    sent = [];
    editor.replace(denser(6)(someScene()));
    expect(density(editor)).toBe(6);
    expect(sent).toEqual([]);
    expect(editor.steps.value.past).toEqual([]);
  });

  it("cutScene sends the scene and is not an undo step", () => {
    begin();
    editor.cutScene(denser(4)(someScene()), true);
    expect(sent.map(({ rest }) => rest)).toEqual([true]);
    expect(editor.steps.value.past).toEqual([]);
  });
});

describe("SceneEditor.setComfort", () => {
  const red = (name: string): Scene => {
    const scene = someScene();
    const [first, ...others] = transferOf(scene).channels;
    if (!first) throw new Error("The scene has no material.");
    const channels = [{ ...first, name: "muscle", diffuse: rgbOf("#c86460") }, ...others];
    return { ...setDensity(scene, name === "muscle" ? 1.1 : 2), transferFunction: { ...transferOf(scene), channels } };
  };
  it("stays with another look, which counts as chosen, and goes with undo", () => {
    const [muscle, deep] = [preset("muscle", red("muscle")), preset("deep", denser(2)(red("deep")))];
    begin(red("muscle"), [muscle, deep]);
    editor.setComfort(1.5, false);
    expect([editor.comfort(), editor.activePreset()?.name]).toEqual([1.5, "muscle"]);
    editor.applyPreset(deep);
    expect([editor.comfort(), editor.activePreset()?.name]).toEqual([1.5, "deep"]);
    editor.undo();
    editor.undo();
    expect([editor.comfort(), editor.activePreset()?.name]).toEqual([0, "muscle"]);
    editor.setComfort(2, false);
    editor.reset("look");
    expect(editor.comfort()).toBe(0);
  });
});
