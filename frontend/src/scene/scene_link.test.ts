import { create, equals, toBinary } from "@bufbuild/protobuf";
import { deflateRawSync } from "node:zlib";
import { describe, expect, it } from "vitest";
import { OpacityPointSchema, SceneSchema, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { linkOf, sceneOfLink } from "./scene_link";
import { someScene } from "./testing";

const link = async (scene: Scene): Promise<string> => (await linkOf(scene)) ?? "";
const kind = async (hash: string) => (await sceneOfLink(hash)).kind;
const address = (bytes: Uint8Array, version = "1") =>
  `#view=${version}.${Buffer.from(deflateRawSync(bytes)).toString("base64url")}`;

describe("a scene in a URL", () => {
  it("is restored with everything but its names", async () => {
    const scene = someScene();
    const back = await sceneOfLink(await link(scene));
    const bare = someScene();
    for (const channel of bare.transferFunction?.channels ?? []) channel.name = "";
    for (const light of bare.lights) light.name = "";
    expect(back.kind === "scene" && equals(SceneSchema, back.scene, bare)).toBe(true);
    expect(scene.lights[0]?.name).toBe("key"); // what is shown stays as it is
  });
  it("contains no user's text and no image", async () => {
    const scene = someScene();
    const [channel] = scene.transferFunction?.channels ?? [];
    if (channel) channel.name = "Erika Mustermann";
    const [light] = scene.lights;
    if (light) light.name = "born 1937";
    const plain = await link(someScene());
    expect(await link(scene)).toBe(plain);
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
    expect(await linkOf(scene)).toBeNull();
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
