import { create } from "@bufbuild/protobuf";
import { beforeEach, describe, expect, it } from "vitest";
import type { CameraPose } from "../input/camera";
import { length, subtract, vec3, type Vec3 } from "../input/vec3";
import { PresetSchema } from "../protocol/gen/api/proto/scene_pb";
import { ConfigSchema } from "../protocol/gen/api/proto/stream_pb";
import { cameraOf, withCamera, type Scene } from "../protocol/messages";
import { someScene } from "../scene/testing";
import { setDensity } from "../scene/transfer";
import { SceneEditor } from "../video/scene_editor";
import type { Motion } from "./mapped_camera";
import { PictureLink, showSameRegion } from "./picture_link";

const orbit = { kind: "rotate", right: 0.3, down: 0.1 } as const;

class Picture {
  viewport = { width: 300, height: 300 };
  sent: { scene: Scene; rest: boolean }[] = [];
  rests = 0;
  leads = true;
  readonly editor = new SceneEditor({
    leads: () => this.leads,
    canvasSize: () => this.viewport,
    send: (scene, rest) => this.sent.push({ scene, rest }),
    rest: () => (this.rests += 1),
  });

  begin(scene: Scene, names: readonly string[]): void {
    const presets = names.map((name, i) => create(PresetSchema, { name, scene: setDensity(scene, i + 1) }));
    this.editor.configured(create(ConfigSchema, { scene: setDensity(scene, 1), presets }), true);
  }

  get pose(): CameraPose {
    const scene = this.editor.scene.value;
    const pose = scene && cameraOf(scene);
    if (!pose) throw new Error("no camera");
    return pose;
  }
}

/** A scene that frames `centre` from the front, at a distance. */
const framed = (centre: Vec3, distance: number): Scene =>
  withCamera(someScene(), {
    eye: vec3(centre.x, centre.y - distance, centre.z),
    target: centre,
    up: vec3(0, 0, 1),
    verticalFovDegrees: 30,
  });

const near = (a: Vec3, b: Vec3) => expect(length(subtract(a, b))).toBeLessThan(1e-6);
const away = ({ eye, target }: CameraPose) => subtract(eye, target);
const shift: Motion = [1, 0, 0, 20, 0, 1, 0, -5, 0, 0, 1, 7, 0, 0, 0, 1];

let first: Picture;
let second: Picture;
let link: PictureLink;

beforeEach(() => {
  [first, second] = [new Picture(), new Picture()];
  first.begin(framed(vec3(0, 0, 0), 500), ["skin", "bone"]);
  second.begin(framed(vec3(10, 20, 30), 250), ["skin", "bone"]);
  link = new PictureLink([first, second]);
  [first.sent, second.sent] = [[], []];
});

describe("two linked pictures", () => {
  it("turn together, in one step and without an echo", () => {
    link.link("sides", null);
    [first.sent, second.sent] = [[], []];
    first.editor.act(orbit, true);
    expect(first.sent).toHaveLength(1);
    expect(second.sent).toHaveLength(1);
    near(away(second.pose), { x: away(first.pose).x / 2, y: away(first.pose).y / 2, z: away(first.pose).z / 2 });
    near(second.pose.target, vec3(10, 20, 30));
    second.editor.act(orbit, true);
    expect(first.sent).toHaveLength(2);
    expect(second.sent).toHaveLength(2);
  });

  it("come to rest together", () => {
    link.link("sides", null);
    const before = second.rests;
    first.editor.act(orbit, true);
    expect(second.rests).toBe(before);
    first.editor.rest();
    expect(second.rests).toBe(before + 1);
    expect(first.rests).toBe(1);
  });

  it("see the same place if the scans are aligned", () => {
    link.link("places", shift);
    near(second.pose.target, vec3(-20, 5, -7));
    second.editor.act(orbit);
    near(first.pose.target, vec3(0, 0, 0));
    near(away(first.pose), away(second.pose));
  });

  it("are undone in the picture that was turned, and the other follows", () => {
    link.link("sides", null);
    const before = second.pose;
    first.editor.act(orbit);
    expect(second.editor.steps.value.past).toEqual([]);
    first.editor.undo();
    near(second.pose.eye, before.eye);
  });

  it("show the same look, if both have it", () => {
    link.link("sides", null);
    const bone = first.editor.presets.value[1];
    if (bone) first.editor.applyPreset(bone);
    expect(second.editor.activePreset()?.name).toBe("bone");
    const skin = second.editor.presets.value[0];
    if (skin) second.editor.applyPreset(skin);
    expect(first.editor.activePreset()?.name).toBe("skin");
  });

  it("keep the look that the other lacks", () => {
    const lacking = new Picture();
    lacking.begin(framed(vec3(0, 0, 0), 100), ["brain"]);
    link = new PictureLink([first, lacking]);
    link.link("sides", null);
    const bone = first.editor.presets.value[1];
    if (bone) first.editor.applyPreset(bone);
    expect(lacking.editor.activePreset()?.name).toBe("brain");
  });

  it("do not follow a window that changes its shape, which reframes both", () => {
    link.link("sides", null);
    const before = second.sent.length;
    const shape = { width: 150, height: 300 };
    first.editor.resized(first.viewport, shape);
    first.viewport = shape;
    expect(second.sent).toHaveLength(before);
    first.editor.act(orbit);
    expect(length(away(second.pose))).toBeCloseTo(length(away(first.pose)) / 4);
  });

  it("move alone once they are unlinked, and are joined by the one that was turned last", () => {
    link.link("sides", null);
    link.link("off", null);
    const before = first.pose;
    second.editor.act(orbit);
    expect(first.pose).toEqual(before);
    link.link("sides", null);
    near(away(first.pose), { x: 2 * away(second.pose).x, y: 2 * away(second.pose).y, z: 2 * away(second.pose).z });
  });

  it("are free after the page is left", () => {
    link.link("sides", null);
    const before = second.pose;
    link.close();
    first.editor.act(orbit);
    expect(second.pose).toEqual(before);
  });
});

describe("showSameRegion", () => {
  it("tells whether a camera at the same place shows both subjects", () => {
    expect(showSameRegion(first.editor, second.editor, shift)).toBe(true);
    const far: Motion = [1, 0, 0, 900, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    expect(showSameRegion(first.editor, second.editor, far)).toBe(false);
  });
});
