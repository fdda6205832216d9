import { create, equals, toBinary } from "@bufbuild/protobuf";
import { deflateRawSync } from "node:zlib";
import { describe, expect, it } from "vitest";
import { OpacityPointSchema, SceneSchema, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { linkOf, sceneOfLink } from "./scene_link";
import { someScene } from "./testing";
import { setTexture, type TextureFiles } from "./textures";

const files: TextureFiles = new Map([
  ["window", new Uint8Array([1, 2, 3])],
  ["studio", new Uint8Array([1, 2, 4])],
]);
const link = async (scene: Scene): Promise<string> => (await linkOf(scene, files)) ?? "";
const restored = async (hash: string): Promise<Scene> => {
  const linked = await sceneOfLink(hash, files);
  return linked.kind === "scene" ? linked.scene : expect.unreachable();
};
const kind = async (hash: string) => (await sceneOfLink(hash, files)).kind;
const address = (bytes: Uint8Array, version = "1") =>
  `#view=${version}.${Buffer.from(deflateRawSync(bytes)).toString("base64url")}`;

describe("a scene in a URL", () => {
  it("is restored with everything, such as the names of lights and materials", async () => {
    const scene = someScene();
    expect(equals(SceneSchema, await restored(await link(scene)), scene)).toBe(true);
    expect(scene.lights.map(({ name }) => name)).toContain("key");
  });
  it("refers to the built-in patterns of lights", async () => {
    const window = files.get("window") ?? expect.unreachable();
    const scene = setTexture(someScene(), 0, window, 40);
    const hash = await link(scene);
    expect(equals(SceneSchema, await restored(hash), scene)).toBe(true);
    // Another browser encodes the same pattern in other bytes.
    const other = await sceneOfLink(hash, new Map([["window", new Uint8Array([9])]]));
    expect(other.kind === "scene" && other.scene.lights[0]?.shape.value?.texture).toMatchObject({
      picture: new Uint8Array([9]),
      projectionDegrees: 40,
    });
  });
  it("contains no image, and nobody else's either", async () => {
    const scene = setTexture(someScene(), 0, new Uint8Array([7, 7, 7]), 40);
    expect(await link(scene)).toBe(await link(someScene()));
    const written = address(toBinary(SceneSchema, create(SceneSchema, scene)));
    expect(equals(SceneSchema, await restored(written), someScene())).toBe(true);
  });
  it("has no longer names than the page accepts, whoever wrote it", async () => {
    const scene = someScene();
    for (const one of [...scene.lights, ...(scene.transferFunction?.channels ?? [])]) one.name = "x".repeat(500);
    const back = await restored(address(toBinary(SceneSchema, scene)));
    expect(back.lights.every(({ name }) => name.length === 60)).toBe(true);
    expect(back.transferFunction?.channels.every(({ name }) => name.length === 60)).toBe(true);
  });
  it("is short and has only characters that mail programs and messengers keep", async () => {
    const hash = await link(someScene());
    expect(hash).toMatch(/^#view=1\.[A-Za-z0-9_-]+$/);
    expect(hash.length).toBeLessThan(2000);
  });
  it("is refused if it is too large", async () => {
    const scene = someScene();
    const points = Array.from({ length: 1000 }, (_, n) =>
      create(OpacityPointSchema, { value: n + Math.sin(7 * n) / 3, opacity: Math.abs(Math.sin(n * n)) }),
    );
    const [channel] = scene.transferFunction?.channels ?? [];
    if (channel) channel.opacity = points;
    expect(await linkOf(scene, files)).toBeNull();
  });
});

describe("the fragment of a URL", () => {
  it("may be unrelated to a scene", async () => {
    for (const hash of ["", "#", "#look=x", "#token=view=1.abc"]) expect(await kind(hash)).toBe("none");
  });
  it("may be of a later version", async () => {
    const hash = await link(someScene());
    expect(await kind(hash.replace("=1.", "=2."))).toBe("newer");
    expect(await kind(hash.replace("=1.", "=9999."))).toBe("newer");
  });
  it("may be invalid, cut off, or of a version that never existed", async () => {
    const hash = await link(someScene());
    const junk = [
      "#view=",
      "#view=1",
      "#view=1.",
      "#view=1.!!!",
      "#view=0.abcd",
      "#view=-1.abcd",
      "#view=1.AAAA",
      hash.slice(0, -8),
      `${hash}%20`,
      `#view=1.${"A".repeat(9000)}`,
    ];
    for (const one of junk) expect(await kind(one), one).toBe("damaged");
  });
  it("may be valid data without a complete scene", async () => {
    expect(await kind(address(new Uint8Array()))).toBe("damaged");
    expect(await kind(address(new TextEncoder().encode("this is not a scene")))).toBe("damaged");
  });
  it("may inflate to gigabytes, of which only as much as a scene is read", async () => {
    expect(await kind(address(new Uint8Array(4_000_000)))).toBe("damaged");
    const scene = someScene();
    for (const light of scene.lights) light.name = " ".repeat(1_000_000);
    expect(await kind(address(toBinary(SceneSchema, scene)))).toBe("damaged");
  });
});
