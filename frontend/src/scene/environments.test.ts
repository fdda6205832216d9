import { expect, test } from "vitest";
import type { Light, Scene } from "../protocol/gen/api/proto/scene_pb";
import { sceneFromJson, sceneToJson } from "../protocol/messages";
import { previewPixels, rotationOf, setStored, storedIn, storedOf, turnEnvironment } from "./environments";
import { addLight, radianceOf } from "./lights";
import { linkOf, sceneOfLink } from "./scene_link";
import { someScene } from "./testing";
import { setTexture, textureOf } from "./textures";

const id = "11111111-2222-4333-8444-555555555555";

function lightOf(scene: Scene, index: number): Light {
  const light = scene.lights[index];
  if (!light) throw new Error("no such light");
  return light;
}

const sky = () => {
  const scene = addLight(someScene(), "environment", "Sky", 100);
  return { scene, index: scene.lights.length - 1 };
};

test("a stored environment and a texture replace each other, and the brightness stays", () => {
  const { scene, index } = sky();
  const lit = setStored(setTexture(scene, index, new Uint8Array([1, 2, 3])), index, id);
  const light = lightOf(lit, index);
  expect(storedOf(light)).toBe(id);
  expect(textureOf(light)).toBeNull();
  expect(radianceOf(light)).toEqual(radianceOf(lightOf(scene, index)));
  expect(storedOf(lightOf(setTexture(lit, index, new Uint8Array([1, 2, 3])), index))).toBe("");
  expect(storedOf(lightOf(setStored(lit, index, ""), index))).toBe("");
});

test("only environment lights have one", () => {
  const { scene } = sky();
  expect(setStored(scene, 0, id)).toBe(scene);
  expect(turnEnvironment(scene, 0, 20)).toBe(scene);
  expect(storedIn(scene)).toEqual([]);
});

test("an environment turns within its limits", () => {
  const { scene, index } = sky();
  expect(rotationOf(lightOf(turnEnvironment(scene, index, -60), index))).toBe(-60);
  expect(rotationOf(lightOf(turnEnvironment(scene, index, 500), index))).toBe(180);
});

test("presets and links carry the reference and the rotation", async () => {
  const { scene, index } = sky();
  const lit = turnEnvironment(setStored(scene, index, id), index, 30);
  expect(storedIn(sceneFromJson(sceneToJson(lit)) ?? scene)).toEqual([id]);
  const linked = await sceneOfLink((await linkOf(lit, new Map())) ?? "", new Map());
  expect(linked.kind).toBe("scene");
  if (linked.kind !== "scene") return;
  expect(storedIn(linked.scene)).toEqual([id]);
  expect(rotationOf(lightOf(linked.scene, index))).toBe(30);
});

test("a preview has three colours per pixel", () => {
  const { rgba } = previewPixels("0a0b0c" + "ff0000".repeat(511));
  expect([...rgba.slice(0, 4)]).toEqual([10, 11, 12, 255]);
  expect([...rgba.slice(-4)]).toEqual([255, 0, 0, 255]);
});
